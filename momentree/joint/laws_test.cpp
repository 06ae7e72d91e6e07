// Laws that every kind of joint obeys: as declared, with armature, reversed, with locked DoFs. A new file in kinds/ is covered
// automatically.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>

using namespace momentree;

namespace {

// A joint in one state: coordinates, trigonometry, rates.
template <class K>
struct Sample {
  static constexpr int nq = K::info.nq, nv = K::info.nv;
  std::array<double, 8> q{}, u{}, p{}, armature{};
  std::array<double, 2> c{}, s{};
  LinkConstants link;

  Sample(Draw& draw, bool aligned, bool rotor) : link(random_link(draw, aligned)) {
    JointSpec spec;
    spec.axis = normalized(draw.vector());
    spec.axis2 = normalized(draw.vector());
    spec.pitch = draw();
    if (K::kind == Kind::free)
      for (double& x : link.geometry) x = draw();
    K::Kernels::frame(spec, link.geometry);
    for (int i = 0; i < nq; ++i) q[static_cast<std::size_t>(i)] = 2 * draw();
    K::Kernels::normalise(q.data());
    for (int i = 0; i < nv; ++i) {
      u[static_cast<std::size_t>(i)] = draw();
      p[static_cast<std::size_t>(i)] = draw();
      armature[static_cast<std::size_t>(i)] = rotor ? 1 + 0.5 * draw() : 0;
    }
    turn();
  }
  void turn() {
    for (std::size_t i = 0; i < K::Kernels::angles.size(); ++i) {
      const double angle =
          q[static_cast<std::size_t>(K::Kernels::angles[i])] + (K::Kernels::rotates_about_z ? link.angle_0 : 0.0);
      c[i] = std::cos(angle), s[i] = std::sin(angle);
    }
  }
  JointState<double> joint() const { return {q.data(), c.data(), s.data()}; }
};

// Calls law(tag of the kind, tag of its kernels, armature, aligned) for every kind.
template <class Law>
void for_every_kind(Law law) {
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      using K = typename decltype(tag)::type;
      for (bool aligned : {false, true}) {
        INFO(std::string(K::info.name), aligned ? ", aligned" : "");
        law(tag, std::type_identity<KernelsOf<K, Variant::plain>>{}, false, aligned);
        law(tag, std::type_identity<KernelsOf<K, Variant::armature>>{}, true, aligned);
        law(tag, std::type_identity<KernelsOf<K, Variant::reversed>>{}, true, aligned);
        law(tag, std::type_identity<typename KernelsFor<K, Variant::plain>::Generic>{}, true, aligned);
      }
    });
}

// Functions of the kernels that several laws need, each compiled once, with everything inlined.
template <class L>
[[gnu::noinline]] DenseTransform<double> transform_of(const LinkConstants& link, const JointState<double>& joint) {
  return dense_transform<L, double>(link, joint);
}
template <class L>
[[gnu::noinline]] auto columns_of(const LinkConstants& link, const JointState<double>& joint) {
  return L::template columns<double>(link, joint);
}
template <class L>
[[gnu::noinline]] Motion<double> velocity_of(const LinkConstants& link, const JointState<double>& joint, const Motion<double>& in,
                                             const double* u) {
  return L::template spatial_velocity<double>(link, joint, in, u);
}
template <class L, class K, class Record>
[[gnu::noinline]] void reduce(const Sample<K>& at, SpatialMass<double>& M, Force<double>& D, Record& record) {
  L::template reduce<double>(at.link, at.joint(), at.p.data(), at.armature.data(), M, D, record);
}

// The record of a body with the given Mb and Db.
template <class K, class L>
[[gnu::noinline]] void reduce_body(const Sample<K>& at, const SpatialMass<double>& Mb, const Force<double>& Db, auto& record) {
  Inboard<double> in{Mb, Db, {}};
  reduce<L>(at, in.M, in.D, record);
}

}  // namespace

TEST_CASE("every kind has as many units as coordinates and DoFs, and is found by its name") {
  CHECK(all_kinds().size() >= 9);
  for (const KindInfo& k : all_kinds()) {
    CHECK(find_kind(k.name)->kind == k.kind);
    CHECK(std::string(k.q_units).size() == static_cast<std::size_t>(k.nq));
    CHECK(std::string(k.v_units).size() == static_cast<std::size_t>(k.nv));
  }
  CHECK(find_kind("revolut") == nullptr);
}

TEST_CASE("(6) E is the derivative of the pose, and Edot that of E") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool, bool) {
    using K = typename decltype(kind)::type;
    using L = typename decltype(kernels)::type;
    for (int trial = 0; trial < 20; ++trial) {
      const Sample<K> at(draw, false, false);
      // Along the joint's motion: q̇ = N(q) u.
      std::array<double, 8> qdot{};
      L::template coordinate_rate<double>(at.q.data(), at.u.data(), qdot.data());
      const double h = 1e-5;
      const auto moved = [&](double t) {
        Sample<K> m = at;
        for (std::size_t i = 0; i < 8; ++i) m.q[i] += t * qdot[i];
        m.turn();
        return m;
      };
      const Sample<K> ahead = moved(h), behind = moved(-h);
      const auto x0 = transform_of<L>(at.link, at.joint());
      const auto x1 = transform_of<L>(at.link, ahead.joint()), x2 = transform_of<L>(at.link, behind.joint());
      const auto over = [&](double a, double b) { return (a - b) / (2 * h); };
      const Vec3 rdot{over(x1.r.x, x2.r.x), over(x1.r.y, x2.r.y), over(x1.r.z, x2.r.z)};
      const Mat3 Rdot{over(x1.R.xx, x2.R.xx), over(x1.R.xy, x2.R.xy), over(x1.R.xz, x2.R.xz),
                      over(x1.R.yx, x2.R.yx), over(x1.R.yy, x2.R.yy), over(x1.R.yz, x2.R.yz),
                      over(x1.R.zx, x2.R.zx), over(x1.R.zy, x2.R.zy), over(x1.R.zz, x2.R.zz)};
      const Mat3 W = transpose(x0.R) * Rdot;
      const Motion<double> measured{transpose_times(x0.R, rdot), {W.zy, W.xz, W.yx}};
      const auto E = columns_of<L>(at.link, at.joint());
      Motion<double> expected{};
      for (std::size_t i = 0; i < E.size(); ++i) expected = expected + Motion<double>{at.u[i] * E[i].v, at.u[i] * E[i].w};
      CHECK(distance(flat(measured), flat(expected)) < 1e-8);
      CHECK(distance(flat(velocity_of<L>(at.link, at.joint(), {}, at.u.data())), flat(expected)) < 1e-14);
      const auto E1 = columns_of<L>(at.link, ahead.joint()), E2 = columns_of<L>(at.link, behind.joint());
      for (std::size_t i = 0; i < E.size(); ++i) {
        const auto a = flat(E1[i]), b = flat(E2[i]);
        std::array<double, 6> rate{}, claimed{};
        for (std::size_t k = 0; k < 6; ++k) rate[k] = over(a[k], b[k]);
        if constexpr (requires { L::template columns_rate<double>(at.link, at.joint(), at.u.data()); })
          claimed = flat(L::template columns_rate<double>(at.link, at.joint(), at.u.data())[i]);
        CHECK(distance(rate, claimed) < 1e-8);
      }
    }
  });
}

TEST_CASE("(16) (17) (18) the joint transform of a kind is that of its pose, in both directions") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool rotor, bool aligned) {
    using K = typename decltype(kind)::type;
    using L = typename decltype(kernels)::type;
    const auto law = [&](auto is_aligned) {
      constexpr bool A = decltype(is_aligned)::value;
      for (int trial = 0; trial < 20; ++trial) {
        const Sample<K> at(draw, A, rotor);
        typename L::template Record<double> record{};
        SpatialMass<double> M = random_mass(draw);
        Force<double> D{draw.vector(), draw.vector()};
        reduce<L>(at, M, D, record);
        const auto dense = transform_of<L>(at.link, at.joint());
        SpatialMass<double> M1 = M, M2 = M;
        Force<double> D1 = D, D2 = D;
        Vec3 c1 = draw.vector(), c2 = c1;
        const double mass = 2 + draw();
        const auto& own = L::template joint_transform<A, double>(at.link, at.joint(), record);
        own.inboard(M1), own.inboard(D1), own.inboard(c1, mass);
        dense.inboard(M2), dense.inboard(D2), dense.inboard(c2, mass);
        CHECK(distance(flat(M1), flat(M2)) < 1e-12);
        CHECK(distance(flat(D1), flat(D2)) < 1e-13);
        CHECK(norm(c1 - c2) < 1e-13);
        const auto& again = L::template cached_transform<A, double>(at.link, at.joint(), record);
        const Motion<double> m{draw.vector(), draw.vector()};
        const Force<double> f{draw.vector(), draw.vector()};
        Motion<double> m1 = m, m2 = m;
        again.outboard(m1), dense.outboard(m2);
        CHECK(distance(flat(m1), flat(m2)) < 1e-13);
        Force<double> f1 = f;
        own.inboard(f1);
        CHECK(dot(m1, f) == doctest::Approx(dot(m, f1)).epsilon(1e-12));  // (18): transposes of each other
        const Motion<double> e{draw.vector(), draw.vector()};
        Motion<double> x = e;
        dense.outboard(x);
        CHECK(dot(e, M1 * e) == doctest::Approx(dot(x, M * x)).epsilon(1e-11));  // Xᵀ M X
      }
    };
    if (L::rotates_about_z && aligned) {
      law(std::true_type{});
    } else {
      law(std::false_type{});
    }
  });
}

TEST_CASE("(15) (22) (23) (24) (25) (26) the equations, element by element") {
  Draw draw;
  const auto unit = [](std::size_t i) {
    std::array<double, 6> e{};
    e[i] = 1;
    return Motion<double>{{e[0], e[1], e[2]}, {e[3], e[4], e[5]}};
  };
  for (int trial = 0; trial < 20; ++trial) {
    RigidMass body{1.5 + draw(), draw.vector(), {3, 4, 5, 0.1, 0.2, 0.3}};
    const SpatialMass<double> children = random_mass(draw);
    SpatialMass<double> M = children;
    Force<double> D{draw.vector(), draw.vector()};
    const Force<double> Db = D;
    const Motion<double> v{draw.vector(), draw.vector()};
    CHECK(distance(flat(articulated_mass(body, M) * v), flat(momentum(body, v) + children * v)) < 1e-13);
    CHECK(distance(flat(remainder_momentum(D)), flat(Db)) == 0);

    // Two columns; Mj⁻¹ in closed form.
    const Columns<double, 2> E{{{draw.vector(), draw.vector()}, {draw.vector(), draw.vector()}}};
    const std::array<Force<double>, 2> ME{M * E[0], M * E[1]};
    const double armature[2] = {0.1, 0.2};
    const JointMass<double, 2> Mj = joint_space_mass<double, 2>(E, ME, armature);
    const double a = dot(E[0], M * E[0]) + 0.1, b = dot(E[1], M * E[0]), c = dot(E[1], M * E[1]) + 0.2, det = a * c - b * b;
    CHECK(distance(std::array{Mj(0, 0), Mj(1, 0), Mj(1, 1)}, std::array{a, b, c}) < 1e-13);
    const std::array<Force<double>, 2> G{(c / det) * ME[0] - (b / det) * ME[1], (a / det) * ME[1] - (b / det) * ME[0]};
    const SpatialMass<double> Mb = M;
    reduced_mass(G, ME, M);
    for (std::size_t i = 0; i < 6; ++i) {
      const Force<double> expected = Mb * unit(i) - dot(unit(i), ME[0]) * G[0] - dot(unit(i), ME[1]) * G[1];
      CHECK(distance(flat(M * unit(i)), flat(expected)) < 1e-12);
    }
    const std::array<double, 2> r{draw(), draw()};
    reduced_remainder(G, r, D);
    CHECK(distance(flat(D), flat(Db + r[0] * G[0] + r[1] * G[1])) < 1e-12);

    // The weight of two points, about the origin.
    const Vec3 g = draw.vector(), one = draw.vector(), two = draw.vector();
    const Force<double> weight = accumulated_force(5.0, 2.0 * one + 3.0 * two, g);
    CHECK(norm(weight.l - (2.0 * g + 3.0 * g)) < 1e-14);
    CHECK(norm(weight.h - (cross(one, 2.0 * g) + cross(two, 3.0 * g))) < 1e-13);
  }
}

TEST_CASE("(24) (25) (26) (27) (21) (20) the functions of a kind equal the generic ones") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool rotor, bool) {
    using K = typename decltype(kind)::type;
    using L = typename decltype(kernels)::type;
    constexpr int N = K::info.nv;
    for (int trial = 0; trial < 20; ++trial) {
      const Sample<K> at(draw, false, rotor);
      const SpatialMass<double> Mb = random_mass(draw);
      const Force<double> Db{draw.vector(), draw.vector()};
      const auto E = columns_of<L>(at.link, at.joint());
      SpatialMass<double> M1 = Mb, M2 = Mb;
      Force<double> D1 = Db, D2 = Db;
      typename L::template Record<double> own{};
      GenericRecord<double, N> generic{};
      reduce<L>(at, M1, D1, own);
      reduce_generic<double, N>(E, at.p.data(), at.armature.data(), M2, D2, generic);
      CHECK(distance(flat(M1), flat(M2)) < 1e-12);
      CHECK(distance(flat(D1), flat(D2)) < 1e-12);
      const Motion<double> in{draw.vector(), draw.vector()};
      std::array<double, 8> u1{}, u2{};
      L::joint_velocity(own, in, u1.data());
      for (int i = 0; i < N; ++i)
        u2[static_cast<std::size_t>(i)] =
            generic.u0[static_cast<std::size_t>(i)] - dot(in, generic.G[static_cast<std::size_t>(i)]);
      CHECK(distance(u1, u2) < 1e-11);
      const Force<double> P1 = L::articulated_momentum(own, at.p.data(), in);
      const Motion<double> out = velocity_of<L>(at.link, at.joint(), in, u1.data());
      CHECK(distance(flat(P1), flat(Mb * out + Db)) < 1e-11);  // (21) by definition
      for (int i = 0; i < N; ++i) {                            // (19): p = Eᵀ Pb + armature · u
        const auto k = static_cast<std::size_t>(i);
        CHECK(at.p[k] == doctest::Approx(dot(E[k], P1) + at.armature[k] * u1[k]).epsilon(1e-11));
      }
      const Force<double> wrench{draw.vector(), draw.vector()};
      std::array<double, 8> rate{};
      L::template momentum_rate<double>(at.link, at.joint(), at.u.data(), P1, wrench, rate.data());
      for (int i = 0; i < N; ++i) {
        const auto k = static_cast<std::size_t>(i);
        double expected = dot(E[k], wrench);
        if constexpr (requires { L::template columns_rate<double>(at.link, at.joint(), at.u.data()); })
          expected += dot(L::template columns_rate<double>(at.link, at.joint(), at.u.data())[k], P1);
        CHECK(rate[k] == doctest::Approx(expected).epsilon(1e-12));
      }
    }
  });
}

TEST_CASE("a spring's force is the gradient of its energy along the joint's motion") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool, bool) {
    using K = typename decltype(kind)::type;
    using L = typename decltype(kernels)::type;
    for (int trial = 0; trial < 20; ++trial) {
      const Sample<K> at(draw, false, false);
      const Sample<K> rest(draw, false, false);
      std::array<double, 6> k{}, force{}, ignore{};
      for (double& x : k) x = 1.5 + draw();
      L::spring(at.q.data(), rest.q.data(), k.data(), force.data());
      std::array<double, 8> qdot{}, q1 = at.q, q2 = at.q;
      L::template coordinate_rate<double>(at.q.data(), at.u.data(), qdot.data());
      const double h = 1e-6;
      for (std::size_t i = 0; i < 8; ++i) q1[i] += h * qdot[i], q2[i] -= h * qdot[i];
      L::normalise(q1.data()), L::normalise(q2.data());
      const double V1 = L::spring(q1.data(), rest.q.data(), k.data(), ignore.data());
      const double V2 = L::spring(q2.data(), rest.q.data(), k.data(), ignore.data());
      double power = 0;
      for (int i = 0; i < K::info.nv; ++i) power += force[static_cast<std::size_t>(i)] * at.u[static_cast<std::size_t>(i)];
      CHECK(power == doctest::Approx(-(V1 - V2) / (2 * h)).epsilon(1e-6));
    }
  });
}

TEST_CASE("at zero a joint's frames coincide; normalising keeps normalised coordinates") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool, bool) {
    using K = typename decltype(kind)::type;
    using L = typename decltype(kernels)::type;
    Sample<K> at(draw, false, false);
    L::zero(at.q.data());
    at.turn();
    const auto x = transform_of<L>(at.link, at.joint());
    const Mat3 R = placement_rotation(at.link);
    Vec3 own{};  // where the kernel frame is from the joint's
    if constexpr (requires { L::template offset<double>(at.link); }) own = L::template offset<double>(at.link);
    CHECK(norm(x.r - (at.link.r + R * own)) < 1e-15);
    const Vec3 v = draw.vector();
    CHECK(norm(x.R * v - R * v) < 1e-14);
    Sample<K> other(draw, false, false);
    const auto q = other.q;
    L::normalise(other.q.data());
    CHECK(distance(q, other.q) < 1e-15);
  });
}

TEST_CASE("(24) (27) (20) locked DoFs have no velocity and no rate; the others satisfy the equations of the unlocked ones") {
  Draw draw;
  for_every_kind([&](auto kind, auto, bool, bool) {
    using K = typename decltype(kind)::type;
    constexpr int N = K::info.nv;
    const auto law = [&](auto kernels) {
      using L = typename decltype(kernels)::type;
      for (unsigned locked = 1; locked < (1u << N); ++locked) {
        Sample<K> at(draw, false, true);
        at.link.locked = static_cast<unsigned char>(locked);
        for (int i = 0; i < N; ++i)
          if ((locked >> i & 1u) != 0) at.p[static_cast<std::size_t>(i)] = 0;
        const SpatialMass<double> Mb = random_mass(draw);
        const Force<double> Db{draw.vector(), draw.vector()};
        SpatialMass<double> M = Mb;
        Force<double> D = Db;
        typename L::template Record<double> record{};
        reduce<L>(at, M, D, record);
        const Motion<double> in{draw.vector(), draw.vector()};
        std::array<double, 8> u{}, rate{};
        L::joint_velocity(record, in, u.data());
        const Motion<double> out = velocity_of<L>(at.link, at.joint(), in, u.data());
        const Force<double> P = Mb * out + Db;
        CHECK(distance(flat(L::articulated_momentum(record, at.p.data(), in)), flat(P)) < 1e-11);
        L::template momentum_rate<double>(at.link, at.joint(), u.data(), P, P, rate.data());
        const auto E = columns_of<L>(at.link, at.joint());
        for (int i = 0; i < N; ++i) {
          const auto k = static_cast<std::size_t>(i);
          if ((locked >> i & 1u) != 0) {
            CHECK(u[k] == 0);
            CHECK(rate[k] == 0);
          } else {
            CHECK(at.p[k] == doctest::Approx(dot(E[k], P) + at.armature[k] * u[k]).epsilon(1e-10));
          }
        }
      }
    };
    if constexpr (N > 0) {
      law(std::type_identity<KernelsOf<K, Variant::locked>>{});
      law(std::type_identity<KernelsOf<K, Variant::reversed_locked>>{});
    }
  });
}

namespace {
// The laws of the second recursion at one joint whose DoFs in `locked` are at rest.
template <class K, class L>
void acceleration_laws(Draw& draw, const Sample<K>& at) {
  constexpr int N = K::info.nv;
  const auto columns = columns_of<L>(at.link, at.joint());
  const auto locked = [&](std::size_t i) { return (at.link.locked >> i & 1u) != 0; };
  const SpatialMass<double> Mb = random_mass(draw);
  const Force<double> Db{draw.vector(), draw.vector()};
  typename L::template Record<double> record{};
  std::array<double, 8> u = at.u, tau{}, udot{}, rotor = at.armature;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    tau[i] = draw();
    if (locked(i)) u[i] = tau[i] = 0;
  }
  reduce_body<K, L>(at, Mb, Db, record);

  // (39): dΩ/dt = X dΩ_parent/dt + Ω × E u + Ė u + E u̇
  const Motion<double> velocity{draw.vector(), draw.vector()};
  Motion<double> relative{}, turning{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    relative = relative + Motion<double>{u[i] * columns[i].v, u[i] * columns[i].w};
    if constexpr (requires { L::template columns_rate<double>(at.link, at.joint(), u.data()); }) {
      const Motion<double> rate = L::template columns_rate<double>(at.link, at.joint(), u.data())[i];
      turning = turning + Motion<double>{u[i] * rate.v, u[i] * rate.w};
    }
  }
  const Motion<double> bias = L::template acceleration_bias<double>(at.link, at.joint(), velocity, u.data());
  CHECK(distance(flat(bias), flat(cross(velocity, relative) + turning)) < 1e-13);
  Force<double> sparse{}, full{};
  L::add_reduced_bias(record, bias, sparse);
  L::add_reduced(record, bias, full);
  CHECK(distance(flat(sparse), flat(full)) < 1e-12);

  // (47), (51): the kernels' u̇ and Tr satisfy Tr = Mb Ω̇ + W with Eᵀ Tr = τ − armature · u̇
  const Force<double> W{draw.vector(), draw.vector()};
  const Motion<double> in{draw.vector(), draw.vector()};
  Force<double> Tr = W;
  L::template reduce_wrench<double>(at.link, at.joint(), record, tau.data(), Tr, udot.data());
  L::joint_acceleration(record, in, udot.data());
  L::add_reduced(record, in, Tr);
  const Motion<double> out = velocity_of<L>(at.link, at.joint(), in, udot.data());
  CHECK(distance(flat(Tr), flat(Mb * out + W)) < 1e-10);
  std::array<double, 8> force{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(N); ++i) {
    force[i] = locked(i) ? 0 : dot(columns[i], Tr);
    if (locked(i)) {
      CHECK(udot[i] == 0);
    } else {
      CHECK(force[i] == doctest::Approx(tau[i] - rotor[i] * udot[i]).epsilon(1e-9));
    }
  }
  // The drive accounts for all of it: nothing is left along the DoFs.
  const Force<double> rest = Tr - L::drive_wrench(at.link, at.joint(), force.data());
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (!locked(i)) CHECK(std::fabs(dot(columns[i], rest)) < 1e-12 * (1 + norm(Tr.l) + norm(Tr.h)));
}
}  // namespace

TEST_CASE("(39) (47) (51) accelerations and the wrench of a joint, by every kind's kernels, with and without locked DoFs") {
  Draw draw;
  for_every_kind([&](auto kind, auto kernels, bool rotor, bool) {
    using K = typename decltype(kind)::type;
    for (int trial = 0; trial < 20; ++trial)
      acceleration_laws<K, typename decltype(kernels)::type>(draw, Sample<K>(draw, false, rotor));
    if constexpr (K::info.nv > 0) {
      for (unsigned locked = 1; locked < (1u << K::info.nv); ++locked) {
        Sample<K> at(draw, false, true);
        at.link.locked = static_cast<unsigned char>(locked);
        acceleration_laws<K, KernelsOf<K, Variant::locked>>(draw, at);
        acceleration_laws<K, KernelsOf<K, Variant::reversed_locked>>(draw, at);
      }
    }
  });
}
