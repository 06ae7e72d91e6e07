// Armatures and prescribed motions of loop joints, and exact couplings, in momenta: against the same mechanism in velocities,
// against derivatives by differences, and against the same mechanism with another tree, in which they belong to a joint of the
// tree. Also the rates of momenta, and the rows that the method `damped` keeps for a step.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_measures.hpp>
#include <tests/oracle/loop_rows.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

/// A sine that begins at `value`.
std::shared_ptr<const JointDrive> motion_from(double value, Prng& random) {
  const double amplitude = random.uniform(0.05, 0.2), phase = random.uniform(-1, 1);
  return motion_drive(Signal::sine(amplitude, random.uniform(0.3, 1), phase, value - amplitude * std::sin(phase)));
}

/// Armatures of all DoFs of loop joints, a prescribed motion of one loop joint, if it has one DoF, and exact couplings.
Model completed(const Model& model, std::uint64_t seed, bool coupled) {
  Prng random(seed + 500);
  const World start(model, Variables::velocities);
  Model more({.gravity = model.gravity()});
  for (const BodySpec& body : model.bodies()) more.add(body);
  bool moves = random.chance(0.5);
  for (std::size_t i = 0; i < model.loops().size(); ++i) {
    LoopSpec loop = model.loops()[i];
    const KindInfo& kind = info(loop.joint.kind);
    for (int k = 0; k < kind.nv; ++k)
      loop.joint.parameters.armature.push_back(random.chance(0.8) ? std::exp(random.uniform(-3, 2)) : 0.0);
    if (moves && kind.nv == 1) {
      loop.joint.parameters.effort = {}, loop.joint.parameters.limits = {};
      loop.joint.parameters.drive = motion_from(start.joint(start.loops()[i]).q[0], random);
      moves = false;
    }
    more.add_loop(loop);
  }
  if (!coupled) return more;
  std::vector<int> single;
  for (int b = 0; b < model.size(); ++b)
    if (info(model[BodyId{b}].joint.kind).nv == 1) single.push_back(b);
  for (int k = random.integer(1, 2); k > 0 && single.size() > 1; --k) {
    const auto any = [&] { return single[static_cast<std::size_t>(random.integer(0, static_cast<int>(single.size()) - 1))]; };
    Coupling law{.joint = {any()}, .follows = {any()}, .multiplier = random.uniform(-2, 2)};
    if (law.joint == law.follows) continue;
    law.higher = {random.uniform(-1, 1), random.uniform(-0.5, 0.5), 0};
    law.offset = start.joint(law.joint).q[0] - (law.value(start.joint(law.follows).q[0]) - law.offset);
    more.add_coupling(law);
  }
  return more;
}

}  // namespace

TEST_CASE("momenta with armatures, motions and couplings: rates of 1500 random mechanisms, for any impulses since the start") {
  int compared = 0, moved = 0, soft = 0, coupled = 0, skipped = 0;
  double worst = 0, worst_rate = 0, worst_momenta = 0;
  for (std::uint64_t seed = 0; compared < 1500; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.drives = seed % 2 == 1;
    const Model open = with_loops(seed, options, seed % 8 > 5);
    if (dofs(open) == 0 || check_assembly(open)) continue;
    const Model model = completed(open, seed, seed % 3 == 0);
    if (!has_equations(model) || check_assembly(model)) continue;
    const World velocities(model, Variables::velocities);
    const World momenta(model, Variables::momenta, Variables::momenta);
    const Tree& tree = momenta.tree();
    const int n = tree.nv(), nq = tree.nq();
    REQUIRE(momenta.state().variables() == Variables::momenta);
    const Vector u = as_vector(velocities.v()), a = as_vector(velocities.a()), p = as_vector(momenta.p());
    const double speed = 1 + largest(u), noise = 1e-15 * amplification(velocities, p);
    const Matrix J = rows_of(velocities);
    Workspace<double> workspace(tree);
    evaluate_state_with_loops(tree, momenta.state(), workspace);
    LoopWorkspace& loops = *workspace.loops;
    double least = 1;  // pivot of the chosen rows, relative to their scale
    for (std::size_t i = 0; i < loops.kept.rows.size(); ++i) {
      const double pivot = loops.factor[static_cast<std::size_t>(loops.kept.position[i] + static_cast<std::ptrdiff_t>(i))];
      least = std::min(least, pivot * pivot / loops.rows[static_cast<std::size_t>(loops.kept.rows[i])].scale);
    }
    if (noise > 1e-12 || (J.rows() > 0 && nearly_singular(J)) || least < 1e-5) {
      ++skipped;
      continue;
    }
    ++compared;
    moved += tree.loops().motions, soft += tree.loops().armatures, coupled += static_cast<int>(model.couplings().size());
    worst = std::max(worst, largest(as_vector(momenta.v()) - u) / speed);
    CHECK(largest(as_vector(momenta.v()) - u) < 1e-9 * speed);
    const double steep = options.drives ? 100 : 1;  // friction of drives changes fast with velocity
    CHECK(largest(as_vector(momenta.a()) - a) < steep * 1e-10 * (1 + largest(a)) * speed);
    CHECK(momenta.totals().kinetic == doctest::Approx(velocities.totals().kinetic).epsilon(1e-9));
    double loads = 1;  // which ṗ is a sum of
    for (const JointId loop : velocities.loops()) {
      const JointForces one = velocities.joint_forces(loop), other = momenta.joint_forces(loop);
      loads += norm(one.reaction.force) + norm(one.reaction.torque);
      for (int i = 0; i < one.effort.size(); ++i)
        CHECK(std::fabs(one.effort[i] - other.effort[i]) < steep * 1e-9 * loads * speed);
    }
    for (int c = 0; c < velocities.couplings(); ++c) {
      const double one = velocities.coupling({c}).effort;
      loads += std::fabs(one);
      CHECK(std::fabs(one - momenta.coupling({c}).effort) < steep * 1e-9 * loads * speed);
    }
    const Vector pdot = as_vector(velocities.pdot());
    CHECK(largest(as_vector(momenta.pdot()) - pdot) < steep * 1e-10 * (loads + largest(pdot)) * speed);

    // ṗ is the derivative of p = H u along the motion.
    const double* const q = momenta.state().q().data();
    const Vector q0 = as_vector(q, nq), qdot = as_vector(velocities.qdot());
    const double step = 2e-3 / (speed + std::sqrt(1 + largest(a)));
    const auto momentum = [&](double t) -> Vector {
      const Vector at = q0 + t * qdot, now = u + t * a;
      Vector found(n);
      project_momentum(tree, at.data(), now.data(), found.data());
      for (const int b : tree.order())
        for (int i = 0; i < info(tree.kind(b)).nv; ++i)
          if ((tree.link(b).locked & ~unsigned{tree.link(b).driven}) >> i & 1u) found(tree.first_p(b) + i) = 0;
      return found;
    };
    const double off_momenta = largest(derivative(momentum, step) - pdot) / ((loads + largest(pdot)) * speed);
    worst_momenta = std::max(worst_momenta, off_momenta);
    CHECK(off_momenta < 1e-7);

    // Impulses σ of any size since the start of the step; then du/dt along q̇ and ṗ* must be u̇.
    Prng random(seed + 77);
    const Power power = workspace.power;
    std::vector<double> impulses(static_cast<std::size_t>(tree.loops().rows));
    for (std::size_t i = 0; i < impulses.size(); ++i) {
      const bool kept = std::binary_search(loops.kept.rows.begin(), loops.kept.rows.end(), static_cast<int>(i));
      impulses[i] = kept || !(loops.rows[i].softness > 0) ? random.uniform(-1, 1) * largest(p) : 0.0;
    }
    detail::place_loops(tree, q, workspace, true);
    detail::sum_loop_momenta(tree, q, workspace, impulses.data());
    std::vector<double> other(momenta.p().begin(), momenta.p().end()), coupling(other.size());
    add_coupling_efforts(tree, workspace, impulses.data(), coupling.data());
    const std::span<const LoopStop> stops = tree.loops().stops;
    for (std::size_t s = 0; s < stops.size(); ++s) {
      const int b = stops[s].body;
      if (s == 0 || stops[s - 1].body != b)
        absorb(tree, b, joint_state(tree, q, workspace, b), loops.momenta[static_cast<std::size_t>(b)], -1, other.data());
    }
    for (std::size_t i = 0; i < other.size(); ++i) other[i] -= coupling[i];
    for (std::size_t i = 0; i < impulses.size(); ++i)  // an armature of speed u had the speed u + σ / I
      loops.speeds[i] += loops.rows[i].softness * impulses[i];
    const double t0 = momenta.time();
    evaluate_with_loops(tree, t0, q, other.data(), workspace, LoopRows::kept);
    const Vector found = as_vector(workspace.v.get(), n);
    const double rounding = 1e-15 * amplification(velocities, as_vector(other.data(), n));
    CHECK(largest(found - u) < 1e-9 * speed + 100 * rounding);
    CHECK(largest(as_vector(workspace.qdot.get(), nq) - qdot) < 1e-10 * speed + 100 * rounding);
    const double scale = 1 + std::fabs(power.dissipated) + std::fabs(power.work);
    CHECK(std::fabs(workspace.power.dissipated - power.dissipated) < steep * 1e-8 * scale);
    CHECK(std::fabs(workspace.power.work - power.work) < steep * 1e-8 * scale);
    const Vector along = as_vector(workspace.qdot.get(), nq), rate = as_vector(workspace.pdot.get(), n);
    const Vector p0 = as_vector(other.data(), n);
    const auto velocity = [&](double t) -> Vector {
      const Vector at = q0 + t * along;
      Vector now = p0 + t * rate;
      for (const int b : tree.joints_with().motions) now(tree.first_p(b)) = prescribed_motion(tree, b).at(t0 + t).rate;
      evaluate_with_loops(tree, t0 + t, at.data(), now.data(), workspace, LoopRows::kept, false);
      return as_vector(workspace.v.get(), n);
    };
    const double off = largest(derivative(velocity, step) - a) / (1 + largest(a) + speed * speed);
    worst_rate = std::max(worst_rate, off - 1e3 * rounding / step);
    CHECK(off < 1e-7 + 1e3 * rounding / step);
  }
  MESSAGE("velocities " << worst << ", rates " << worst_rate << ", momenta " << worst_momenta << "; motions " << moved
                        << ", armatures " << soft << ", couplings " << coupled << ", skipped " << skipped);
  CHECK(moved > 100);
  CHECK(soft > 1000);
  CHECK(coupled > 150);
  CHECK(skipped < 1500);
}

TEST_CASE("momenta with armatures, motions and couplings: runs go where those in velocities go, and keep the energy balance") {
  int runs = 0, stiff = 0;
  for (std::uint64_t seed = 0; runs < 100; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.parameters = seed % 3 != 0, options.conservative = seed % 3 == 1, options.several_mechanisms = seed % 2 == 0;
    const Model open = with_loops(seed, options, seed % 8 == 2);
    if (dofs(open) == 0 || check_assembly(open)) continue;
    const Model model = completed(open, seed, seed % 4 == 1);
    if (!has_equations(model) || check_assembly(model)) continue;
    const World start(model, Variables::velocities);
    if (amplification(start, as_vector(start.p())) > 1e3) continue;
    const double until = 0.1;
    Simulation exact = run_of(model, "dop853", Variables::velocities);
    if (exact.run_until(until).status != Status::ok || fastest(exact.world()) > 20) {
      ++stiff;
      continue;
    }
    ++runs;
    const double speed = fastest(exact.world());
    for (const char* method : {"dop853", "dopri5"}) {
      CAPTURE(method);
      Simulation sim = run_of(model, method, Variables::momenta);
      REQUIRE(sim.run_until(until).status == Status::ok);
      CHECK(sim.world().state().variables() == Variables::momenta);
      CHECK(apart(exact.world(), sim.world()) < 2e-8 * speed * speed);
      const EnergyBalance balance = sim.energy(), other = exact.energy();
      const double scale = 1 + std::fabs(balance.initial) + balance.largest_kinetic + std::fabs(other.work);
      CHECK(std::fabs(balance.dissipated - other.dissipated) < 1e-7 * scale);
      CHECK(std::fabs(balance.work - other.work) < 1e-7 * scale);
      CHECK(std::fabs(balance.error) < 1e-7 * scale);
      CHECK(sim.world().loop_status().residual < 1e-12);
    }
  }
  MESSAGE("too fast: " << stiff);
}

namespace {

/// A chain on the ground whose last body is held by a joint to the ground as well. One of the last two joints closes the loop: of
/// `by_last`, the one to the ground, which has the armatures, dampers and the prescribed motion.
struct Respanned {
  std::vector<BodySpec> chain;  // the last one with its joint to the previous one
  LoopSpec end;

  Model model(bool by_last) const {
    Model all({.gravity = {1, 2, -9}});
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) all.add(chain[i]);
    BodySpec last = chain.back();
    LoopSpec loop = end;
    if (!by_last) {
      loop.name = last.joint_name, loop.joint = last.joint, loop.at = last.at, loop.child_at = last.child_at,
      loop.to = last.parent;
      last.joint_name = end.name, last.joint = end.joint, last.at = end.at, last.child_at = end.child_at, last.parent = ground;
      last.q = {}, last.v = {};
    }
    loop.body = all.add(last);
    all.add_loop(loop);
    return all;
  }
};

Pose random_pose(Prng& random, double size) {
  const Vec3 axis = random.direction();
  return {random.vector(size), from_axis_angle(axis, random.uniform(-1, 1))};
}

const std::vector<Kind> closing_kinds{Kind::revolute,  Kind::prismatic, Kind::helical, Kind::cylindrical,
                                      Kind::universal, Kind::ball,      Kind::planar};

Respanned random_ring(std::uint64_t seed, Kind last, bool moves) {
  Prng random(seed + 9);
  Respanned ring;
  const auto joint = [&](Kind kind) {
    JointSpec spec;
    spec.kind = kind, spec.axis = random.direction(), spec.axis2 = random.direction(), spec.pitch = random.uniform(0.1, 0.5);
    return spec;
  };
  for (int dofs = info(last).nv, k = 0; dofs < 8; ++k) {
    BodySpec body;
    body.name = "body" + std::to_string(k), body.joint_name = "joint" + std::to_string(k);
    body.mass = random.uniform(0.5, 3), body.com = random.vector(0.2);
    body.inertia = diagonal(random.uniform(0.05, 0.06), random.uniform(0.05, 0.06), random.uniform(0.05, 0.06));
    body.parent = {k - 1};
    const Kind kind = random.chance(0.3) ? closing_kinds[static_cast<std::size_t>(random.integer(0, 6))] : Kind::revolute;
    body.joint = joint(kind);
    body.at = random_pose(random, 0.6), body.child_at = random_pose(random, 0.3);
    body.q = random_coordinates(random, kind), body.v = random_velocities(random, kind);
    dofs += info(kind).nv;
    ring.chain.push_back(body);
  }
  LoopSpec& end = ring.end;
  end.name = "end", end.joint = joint(last), end.child_at = random_pose(random, 0.3);
  for (int i = 0; i < info(last).nv; ++i) {
    end.joint.parameters.armature.push_back(std::exp(random.uniform(-3, 2)));
    end.joint.parameters.damping.push_back(random.uniform(0, 0.3));
    end.joint.parameters.stiffness.push_back(random.uniform(0, 3));
  }
  const Values q = random_coordinates(random, last);
  {
    Model open;
    for (const BodySpec& body : ring.chain) open.add(body);
    const World world(open);
    end.at = world.motions().back().pose * end.child_at * inverse(joint_motion(end.joint, q.begin()));
  }
  if (moves) end.joint.parameters.drive = motion_from(q[0], random);
  const World closed(ring.model(true), Variables::velocities);
  for (BodySpec& body : ring.chain) {
    const JointView view = closed.joint({closed.find_joint(body.joint_name)});
    body.q = {}, body.v = {};
    for (const double x : view.q) body.q.push_back(x);
    for (const double x : view.v) body.v.push_back(x);
  }
  return ring;
}

// The same ring spanned through its end: the start values of that joint are those of the loop joint.
Model spanned_through_end(const Respanned& ring) {
  const World closed(ring.model(true), Variables::velocities);
  const JointView view = closed.joint({closed.find_joint("end")});
  const Model model = ring.model(false);
  Model all({.gravity = model.gravity()});
  for (BodySpec body : model.bodies()) {
    if (body.joint_name == "end") {
      body.q = {}, body.v = {};
      for (const double x : view.q) body.q.push_back(x);
      for (const double x : view.v) body.v.push_back(x);
    }
    all.add(body);
  }
  for (const LoopSpec& loop : model.loops()) all.add_loop(loop);
  return all;
}

}  // namespace

TEST_CASE("armatures and motions of loop joints in momenta act as those of the tree's joints, in steps and in changes") {
  int moving = 0, changed = 0;
  const Integration fine{.method = "dop853", .variables = Variables::velocities, .rtol = 1e-11, .atol = 1e-12};
  for (std::uint64_t seed = 0; seed < 84; ++seed) {
    CAPTURE(seed);
    const bool moves = seed % 2 == 1;
    const Kind last = closing_kinds[seed / 2 % (moves ? 3 : 7)];
    const Respanned ring = random_ring(seed, last, moves);
    Integration in_momenta = fine;
    in_momenta.variables = Variables::momenta;
    Simulation one(ring.model(true), in_momenta), other(spanned_through_end(ring), fine);
    REQUIRE(one.world().state().variables() == Variables::momenta);
    CHECK(apart(one.world(), other.world()) < 1e-9 * fastest(other.world()));
    CHECK(one.world().totals().kinetic == doctest::Approx(other.world().totals().kinetic).epsilon(1e-9));
    if (!one.run_until(0.1) || !other.run_until(0.1)) continue;
    ++moving;
    const double speed = fastest(other.world());
    CHECK(apart(one.world(), other.world()) < 1e-8 * speed * speed);
    const JointForces f = one.world().joint_forces({one.world().find_joint("end")});
    const JointForces g = other.world().joint_forces({other.world().find_joint("end")});
    const double size = 1 + norm(f.reaction.force) + norm(f.reaction.torque);
    for (int i = 0; i < f.effort.size(); ++i) CHECK(std::fabs(f.effort[i] - g.effort[i]) < 1e-7 * size * speed);
    const EnergyBalance b = one.energy(), c = other.energy();
    const double scale = 1 + b.largest_kinetic + std::fabs(b.work);
    CHECK(std::fabs(b.error) < 1e-8 * scale);
    CHECK(std::fabs(b.work - c.work) < 1e-7 * scale);
    // A lock stops bodies and rotors alike; the armature of the end must carry its momentum into the impact and out of it.
    const std::string name = ring.chain.front().joint_name;
    const std::vector<Action> jam{lock(name)};  // refused if nothing is left to move, with a motion
    if (!one.try_apply(jam, "jam")) continue;
    REQUIRE(other.try_apply(jam, "jam"));
    CHECK(one.world().state().variables() == Variables::momenta);
    const Event &e = one.events().back(), &h = other.events().back();
    CHECK(std::fabs(e.lost + e.released - h.lost - h.released) < 1e-7 * scale);
    if (!one.run_until(0.15) || !other.run_until(0.15)) continue;
    ++changed;
    CHECK(apart(one.world(), other.world()) < 1e-6 * speed * speed);
  }
  CHECK(moving > 60);
  CHECK(changed > 35);
}

TEST_CASE("armatures and motions of loop joints in momenta: the orders of rk4 and midpoint, and damped") {
  int runs = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const bool moves = seed % 2 == 1;
    const Respanned ring = random_ring(seed, closing_kinds[seed / 2 % (moves ? 3 : 7)], moves);
    Simulation exact = run_of(ring.model(true), "dop853", Variables::velocities);
    if (!exact.run_until(0.2) || fastest(exact.world()) > 15) continue;
    ++runs;
    for (const auto& [method, order] : {std::pair{"rk4", 4}, std::pair{"midpoint", 2}, std::pair{"damped", 3}}) {
      CAPTURE(method);
      double error[2], energy[2];
      for (int k = 0; k < 2; ++k) {
        Simulation sim = run_of(ring.model(true), method, Variables::momenta, k == 0 ? 0.004 : 0.002);
        REQUIRE(sim.run_until(0.2).status == Status::ok);
        error[k] = apart(exact.world(), sim.world()), energy[k] = std::fabs(sim.energy().error);
        CHECK(sim.world().loop_status().residual < 1e-12);
      }
      CHECK((error[1] < 1e-9 || error[1] < error[0] * std::pow(0.5, order) * 1.7));
      CHECK((energy[1] < 1e-8 || energy[1] < energy[0] * std::pow(0.5, order) * 3));
    }
  }
  CHECK(runs > 6);
}

namespace {

/// Bennett's linkage: four equal pairs of links whose equations lose a row only where the loop is closed exactly. Its joints are
/// damped; the first one begins at `angle`.
Model bennett(double damping) {
  constexpr double a = 0.7, alpha = 0.9, b = 0.4;
  const double beta = std::asin(b / a * std::sin(alpha));
  Model model({.gravity = {3, -2, -9}});
  const auto placed = [](double length, double twist) { return Pose{{length, 0, 0}, from_axis_angle({1, 0, 0}, twist)}; };
  const double lengths[4] = {a, b, a, b}, twists[4] = {alpha, beta, alpha, beta};
  // θ1 + θ3 = θ2 + θ4 = 2 π, tan(θ1/2) tan(θ2/2) = sin((β + α)/2) / sin((β − α)/2)
  const double first = 1.1, k = std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2);
  const double second = 2 * std::atan(k / std::tan(first / 2));
  const double angles[3] = {first, second, 2 * std::numbers::pi - first};
  for (int i = 0; i < 3; ++i) {
    BodySpec link;
    link.name = "link" + std::to_string(i), link.mass = 1 + 0.3 * i, link.com = {0.5 * lengths[i], 0.02, 0.03};
    link.inertia = diagonal(0.02, 0.03, 0.04);
    link.joint.kind = Kind::revolute, link.joint.axis = {0, 0, 1};
    link.joint.parameters.damping = {damping};
    link.parent = {i - 1};
    if (i > 0) link.at = placed(lengths[i - 1], twists[i - 1]);
    link.q = angles[i];
    if (i == 0) link.v = 2;
    model.add(link);
  }
  LoopSpec loop;
  loop.name = "pin", loop.body = {2}, loop.to = ground, loop.joint.kind = Kind::revolute, loop.joint.axis = {0, 0, 1};
  loop.child_at = placed(lengths[2], twists[2]);
  loop.at = inverse(placed(lengths[3], twists[3]));
  model.add_loop(loop);
  return model;
}

}  // namespace

TEST_CASE("damped keeps the chosen rows for a step: Bennett's linkage moves, and as accurately as its order says") {
  for (const double damping : {0.05, 5.0}) {
    CAPTURE(damping);
    Simulation exact(bennett(damping), {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
    CHECK(exact.world().loop_status().rows == 5);
    REQUIRE(exact.world().loop_status().rank == 2);
    REQUIRE(exact.run_until(1).status == Status::ok);
    CHECK(std::fabs(exact.world().joint({0}).q[0] - 1.1) > 0.05);
    double error[2];
    for (int k = 0; k < 2; ++k) {
      Simulation sim(bennett(damping), {.method = "damped", .step = k == 0 ? 0.01 : 0.005});
      REQUIRE(sim.run_until(1).status == Status::ok);
      error[k] = std::fabs(sim.world().joint({0}).q[0] - exact.world().joint({0}).q[0]);
      CHECK(sim.world().loop_status().residual < 1e-12);
    }
    MESSAGE("errors " << error[0] << " " << error[1]);
    CHECK(error[0] < 1e-3);
    CHECK(error[1] < error[0] / 4);
  }
}

TEST_CASE("damped keeps loops closed with dampers that are far heavier than the bodies") {
  for (const double damping : {1e3, 1e6, 1e9}) {
    CAPTURE(damping);
    Simulation sim(bennett(damping), {.method = "damped", .step = 0.01});
    REQUIRE(sim.run_until(0.5).status == Status::ok);
    CHECK(sim.world().loop_status().residual < 1e-12);
    const double v = sim.world().joint({0}).v[0];
    CHECK(std::fabs(v) < 30 / damping);
    CHECK(std::fabs(v) > 1e-2 / damping);
  }
}
