// Steps against the generic functions of their kind, and their machine code against the steps, bit for bit: every kind, with
// armature or without, every place of the body, rotation or shape of the link, and pattern of its constants.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <momentree/derive/step.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>
#include <momentree/machine/memory.hpp>
#include <momentree/machine/test_support.hpp>
#include <momentree/machine/x86.hpp>

namespace momentree::derive {
namespace {

/// The generic functions; those of a free joint with the kernel frame away from the joint's origin.
struct GenericFreeOfCentre : SixDofsOfCentre<GenericFreeOfCentre> {};
template <class Kind>
using GenericOf =
    std::conditional_t<std::is_same_v<Kind, Free>, GenericFreeOfCentre, typename KernelsFor<Kind, Variant::plain>::Generic>;

/// The coordinates of a joint, numbers of its DoFs (momenta, or velocities) and forces.
struct TestJoint {
  std::array<double, 8> q{}, p{}, tau{};
  std::array<double, 2> c{}, s{};
  JointState<double> state() const { return {q.data(), c.data(), s.data()}; }
};

/// A body with a joint of this kind. Nothing for a universal joint with nearly parallel axes.
template <class Kind>
std::optional<TestJoint> random_joint(Draw& draw, bool root, LinkConstants& k) {
  using K = typename Kind::Kernels;
  JointSpec spec;
  spec.axis = normalized(draw.vector()), spec.axis2 = normalized(draw.vector());
  spec.pitch = draw();
  if (std::fabs(dot(spec.axis, spec.axis2)) > 0.9) return {};  // nearly parallel axes of a universal joint
  K::frame(spec, k.geometry);
  if (Kind::info.kind == momentree::Kind::free && root)
    for (double& x : k.geometry) x = draw();
  RigidMass body{1.5 + draw(), draw.vector(), {}};
  const Vec3 c = (1 / body.m) * body.mc;
  body.J = {body.m * (c.y * c.y + c.z * c.z) + 0.3,
            body.m * (c.x * c.x + c.z * c.z) + 0.4,
            body.m * (c.x * c.x + c.y * c.y) + 0.5,
            -body.m * c.x * c.y,
            -body.m * c.x * c.z,
            -body.m * c.y * c.z};
  k.body = body;
  TestJoint joint;
  for (std::size_t i = 0; i < 8; ++i) joint.q[i] = 2 * draw(), joint.p[i] = draw();
  for (double& x : joint.tau) x = draw();
  K::normalise(joint.q.data());
  for (std::size_t i = 0; i < K::angles.size(); ++i) {
    const double angle = joint.q[static_cast<std::size_t>(K::angles[i])] + (K::rotates_about_z ? k.angle_0 : 0.0);
    joint.c[i] = std::cos(angle), joint.s[i] = std::sin(angle);
  }
  return joint;
}

/// The numbers of one body, of which T is that of all worlds.
template <class T>
struct Numbers {
  alignas(64) std::array<T, 8> q{}, u{}, qdot{}, a{}, p{}, pdot{};
  std::array<T, 2> c{}, s{};
  std::array<T, 6> armature{};
  std::array<T, 9> from{}, motion{};  ///< what its parent hands to it, and it to its children
  std::array<T, 30> children{}, sum{};
  std::array<T, 256> record{};

  StepArrays arrays() {
    return {.q = q.data(),
            .cos = c.data(),
            .sin = s.data(),
            .u = u.data(),
            .qdot = qdot.data(),
            .a = a.data(),
            .p = p.data(),
            .pdot = pdot.data(),
            .records = record.data(),
            .sums = children.data(),
            .motions = from.data(),
            .armature = armature.data()};
  }
  static StepEntry entry(const void* constants, bool inward) {
    const auto apart = [](auto member, auto other) {
      const Numbers* const none = nullptr;
      return static_cast<std::int32_t>(reinterpret_cast<const char*>(&(none->*other)) -
                                       reinterpret_cast<const char*>(&(none->*member)));
    };
    const std::int32_t to = inward ? apart(&Numbers::children, &Numbers::sum) : apart(&Numbers::from, &Numbers::motion);
    return {nullptr, constants, 0, 0, 0, 0, 0, to};
  }
  template <class F>
  void each(F&& f) {
    for (auto* array : {&q, &u, &qdot, &a, &p, &pdot})
      for (T& x : *array) f(x);
    for (T& x : armature) f(x);
    for (auto* array : {&from, &motion})
      for (T& x : *array) f(x);
    for (auto* array : {&c, &s})
      for (T& x : *array) f(x);
    for (auto* array : {&children, &sum})
      for (T& x : *array) f(x);
    for (T& x : record) f(x);
  }
  bool operator==(const Numbers&) const = default;
};

/// The machine code of a pass has the bits of its operations, in every world.
template <class S, int N>
void check_bits(const Step& step, std::size_t pass, const Handing& how, machine::Target target,
                const std::vector<double>& constants, Draw& draw) {
  target.lanes = N, target.number = sizeof(S);
  if (!machine::processor_runs(target)) return;
  static machine::CodeMemory memory;
  const machine::Function f = step.function(pass, how, target);
  const machine::Bytes bytes = machine::encode_x86(f, machine::allocate(f, target), target);
  const std::uint8_t* const code = memory.put(bytes.all);
  REQUIRE(code != nullptr);
  using T = machine::Worlds<S, N>;
  const std::vector<S> own(constants.begin(), constants.end());
  const StepEntry entry = Numbers<T>::entry(own.data(), pass == step.inward());
  Numbers<T> found;
  found.each([&](T& number) {
    for (S& x : number.x) x = static_cast<S>(draw());
  });
  Numbers<T> expected = found;
  const StepArrays to = expected.arrays(), in = found.arrays();
  std::vector<T> values(f.values.size());
  machine::evaluate<T, S>(f, target, &entry, &to, std::span(values));
  reinterpret_cast<StepFunction>(const_cast<std::uint8_t*>(code) + bytes.entry)(entry, in);
  CHECK(found == expected);
}

/// What the passes find of a body.
struct Results {
  std::array<double, 8> qdot{}, udot{}, u{}, pdot{};
  std::array<double, 9> motion{};
  std::array<double, 30> sum{};
};
template <class X, std::size_t N>
void copy(const X& from, std::array<double, N>& to) {
  std::memcpy(to.data(), static_cast<const void*>(&from), sizeof from);
}
template <class X, std::size_t N>
X read(const std::array<double, N>& from) {
  X to{};
  std::memcpy(static_cast<void*>(&to), from.data(), sizeof to);
  return to;
}

/// The passes by the functions of the recursions, as in velocity.ipp. `in`: the motion and acceleration of the parent.
template <class Kind>
Results velocities(const LinkConstants& k, const double* armature, bool leaf, const TestJoint& joint, Motion<double> velocity,
                   Motion<double> acceleration, Inboard<double> in) {
  using K = GenericOf<Kind>;
  Results r;
  const DenseTransform<double> x = dense_transform<K, double>(k, joint.state());
  velocity.v = {};
  x.outboard(velocity);
  velocity = K::template spatial_velocity<double>(k, joint.state(), velocity, joint.p.data());
  Motion<double> bias = K::template acceleration_bias<double>(k, joint.state(), velocity, joint.p.data());
  bias.v += cross(velocity.w, velocity.v);
  velocity.v = {};
  K::template coordinate_rate<double>(joint.q.data(), joint.p.data(), r.qdot.data());
  if (leaf) in = {};
  articulated_mass(k.body, in.M);
  in.D += gyroscopic_wrench(k.body, velocity);
  typename K::template Record<double> w{};
  K::template reduce<double>(k, joint.state(), joint.tau.data(), armature, in.M, in.D, w);
  K::add_reduced_bias(w, bias, in.D);
  x.inboard(in.M), x.inboard(in.D);
  x.outboard(acceleration);
  acceleration = acceleration + bias;
  K::joint_velocity(w, acceleration, r.udot.data());
  copy(K::template spatial_velocity<double>(k, joint.state(), acceleration, r.udot.data()), r.motion);
  copy(in, r.sum);
  return r;
}

/// The same as in forward.ipp. `mass`: of the body and of all bodies outboard.
template <class Kind>
Results momenta(const LinkConstants& k, const double* armature, bool leaf, bool root, const TestJoint& joint, double mass,
                Outboard<double> out, Inboard<double> in) {
  using K = GenericOf<Kind>;
  Results r;
  const DenseTransform<double> x = dense_transform<K, double>(k, joint.state());
  if (leaf) in = {};
  articulated_mass(k.body, in.M), remainder_momentum(in.D);
  in.mc += k.body.mc;
  const Vec3 moment = in.mc;
  typename K::template Record<double> w{};
  K::template reduce<double>(k, joint.state(), joint.p.data(), armature, in.M, in.D, w);
  w.M = in.M, w.D = in.D;
  x.inboard(in.M), x.inboard(in.D), x.inboard(in.mc, mass);
  x.outboard(out.velocity), x.outboard(out.gravity);
  K::joint_velocity(w, out.velocity, r.u.data());
  const Force<double> Pb = K::articulated_momentum(w, joint.p.data(), out.velocity);
  out.velocity = K::template spatial_velocity<double>(k, joint.state(), out.velocity, r.u.data());
  const Force<double> weight = accumulated_force(mass, moment, out.gravity);
  Force<double> wrench = weight - cross(out.velocity, Pb);
  if constexpr (requires { Kind::Kernels::template gyroscopic<double>(k.body.mc, out.velocity, Pb); })
    if (root && leaf) wrench = weight - Kind::Kernels::template gyroscopic<double>(k.body.mc, out.velocity, Pb);
  K::template momentum_rate<double>(k, joint.state(), r.u.data(), Pb, wrench, r.pdot.data());
  K::template coordinate_rate<double>(joint.q.data(), r.u.data(), r.qdot.data());
  copy(out, r.motion), copy(in, r.sum);
  return r;
}

template <class Kind>
void laws(Draw& draw, StepKey key, bool general, LinkConstants k) {
  const bool leaf = key.place == BodyPlace::leaf || key.place == BodyPlace::single,
             root = key.place == BodyPlace::root || key.place == BodyPlace::single;
  const auto joint = random_joint<Kind>(draw, root, k);
  if (!joint) return;
  const StepKey form = key_of(Kind::info.kind, key.armature, key.place, k);
  key.kind = form.kind, key.shape = form.shape;
  const LinkNumbers link = numbers_of(k);
  if (general)
    add_general_pattern(key);
  else
    add_pattern(link, key);
  const Step step(key);
  std::vector<double> constants(step.constants());
  step.evaluate_constants(link, constants.data());

  Numbers<double> start;
  start.each([&](double& x) { x = draw(); });
  copy(random_mass(draw), start.children);
  start.q = joint->q, start.u = start.p = joint->p, start.c = joint->c, start.s = joint->s;
  start.armature.fill(0);
  if (key.armature) start.armature[0] = 0.5 + 0.4 * draw();
  const double mass = start.record[0] = 2 + draw();
  const auto in = read<Inboard<double>>(start.children);
  auto out = read<Outboard<double>>(start.from);
  Motion<double> acceleration{draw.vector(), draw.vector()};
  if (root) out.velocity = {}, acceleration.w = {};
  if (!key.gravity) out.gravity = {};
  const Results expected = in_momenta(key.passes)
                               ? momenta<Kind>(k, start.armature.data(), leaf, root, *joint, mass, out, in)
                               : velocities<Kind>(k, start.armature.data(), leaf, *joint, out.velocity, acceleration, in);

  for (const bool adds : {false, true}) {
    Numbers<double> found = start;
    found.a = joint->tau;
    copy(out, found.from);
    const StepArrays arrays = found.arrays();
    for (std::size_t pass = 0; pass < step.passes(); ++pass) {
      const bool inward = pass == step.inward();
      const StepEntry entry = Numbers<double>::entry(constants.data(), inward);
      if (pass == 2) copy(acceleration, found.from);
      const machine::Target one;
      const Handing how{.adds = inward && adds};
      const machine::Function f = step.function(pass, how, one);
      std::vector<machine::Worlds<double, 1>> values(f.values.size());
      machine::evaluate<machine::Worlds<double, 1>, double>(f, one, &entry, &arrays, std::span(values));
    }
    const auto close = [](const auto& a, const auto& b, int n) {
      double most = 1, off = 0;
      for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
        most = std::fmax(most, std::fabs(b[i])), off = std::fmax(off, std::fabs(a[i] - b[i]));
      return off < 1e-12 * most;
    };
    CHECK(close(found.qdot, expected.qdot, Kind::info.nq));
    if (in_momenta(key.passes)) {
      CHECK(close(found.u, expected.u, Kind::info.nv));
      CHECK(close(found.pdot, expected.pdot, Kind::info.nv));
    } else {
      CHECK(close(found.a, expected.udot, Kind::info.nv));
    }
    const bool gravity = in_momenta(key.passes) && key.gravity;
    if (!leaf) CHECK(close(found.motion, expected.motion, gravity ? 9 : 6));
    std::array<double, 30> sum = expected.sum;
    for (std::size_t i = 0; adds && i < sum.size(); ++i) sum[i] += start.sum[i];
    if (!root) CHECK(close(found.sum, sum, gravity ? 30 : 27));
  }

  for (std::size_t pass = 0; pass < step.passes(); ++pass) {
    const Handing how{.adds = pass == step.inward() && draw() < 0};
    const machine::Target narrow, wide{.registers = 32, .avx512 = true};
    const auto in_width = [&]<class S, int N>(machine::Worlds<S, N>, const machine::Target& target) {
      check_bits<S, N>(step, pass, how, target, constants, draw);
    };
    in_width(machine::Worlds<double, 1>(), narrow), in_width(machine::Worlds<double, 1>(), wide);
    in_width(machine::Worlds<double, 4>(), narrow), in_width(machine::Worlds<double, 8>(), wide);
    in_width(machine::Worlds<float, 8>(), narrow), in_width(machine::Worlds<float, 16>(), wide);
  }
}

/// Sets some of the numbers that links often have, so that other patterns occur.
void simplify(Draw& draw, LinkConstants& k) {
  if (k.shape == PlacementShape::general)
    for (double* x : {&k.r.x, &k.r.y, &k.r.z})
      if (draw() < 0) *x = 0;
}

}  // namespace

TEST_CASE("(9) (15) (16) (17) (20)–(27) (39) steps equal the generic functions, in every world") {
  Draw draw;
  int kinds = 0;
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      using Kind = typename decltype(tag)::type;
      if constexpr (Kind::info.nv > 0) {
        INFO(std::string(Kind::info.name));
        ++kinds;
        const auto laws_of_links = [&](const StepKey& key, bool general) {
          const auto law = [&](LinkConstants k) {
            simplify(draw, k);
            laws<Kind>(draw, key, general, k);
          };
          for (unsigned r = 0; r <= static_cast<unsigned>(LinkRotation::none); ++r)
            law(random_link(draw, static_cast<LinkRotation>(r)));
          if (!Kind::Kernels::rotates_about_z) return;
          for (unsigned s = 0; s <= static_cast<unsigned>(PlacementShape::parallel_a); ++s)
            law(random_link(draw, static_cast<PlacementShape>(s)));
        };
        for (const BodyPlace place : {BodyPlace::inner, BodyPlace::leaf, BodyPlace::root, BodyPlace::single})
          for (const bool armature : {false, true})
            for (const bool general : {false, true}) {
              if (!has_steps(kind.kind, armature ? Variant::armature : Variant::plain)) continue;
              laws_of_links({.armature = armature, .place = place}, general);
              for (const bool gravity : {false, true})
                laws_of_links({.armature = armature, .passes = Passes::stage_momenta, .gravity = gravity, .place = place},
                              general);
            }
      }
    });
  CHECK(kinds >= 8);
}

}  // namespace momentree::derive
