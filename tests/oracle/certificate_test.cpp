// The certificate of every event, checked against the motion of the bodies: impulses through joints by Newton–Euler, momenta by
// the ground's impulse, energies by the ledger. Random trees of all joint kinds, random actions, several per instant.
#include <array>
#include <cmath>
#include <string>
#include <unordered_map>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

#include "prng.hpp"
#include "random_model.hpp"

using namespace momentree;
using oracle::Prng;

namespace {

struct Momentum {
  Vec3 linear, angular;  // world axes, about the world's origin
};

Momentum momentum_of(const BodySpec& body, const BodyMotion& m) {
  const Mat3 R = rotation_matrix(m.pose.rotation);
  const Vec3 arm = R * body.com, centre = m.pose.position + arm;
  const Vec3 l = body.mass * (m.linear + cross(m.angular, arm));
  return {l, R * (body.inertia * transpose_times(R, m.angular)) + cross(centre, l)};
}

Action random_action(Prng& random, const World& world) {
  const Model& model = world.model();
  const int n = model.size();
  const auto body = [&] { return model[BodyId{random.integer(0, n - 1)}].name; };
  const auto joint = [&] { return std::string(world.joint_name({random.integer(0, n - 1)})); };
  const auto spec = [&] { return oracle::random_joint(random, oracle::random_kind(random), {.parameters = false}); };
  switch (random.integer(0, 9)) {
    case 0: return break_joint(joint());
    case 1: return free_joint(joint());
    case 2: return change_joint(joint(), spec());
    case 3: return lock(joint());
    case 4: return unlock(joint());
    case 5: return weld(body(), body());
    case 6: return attach(body(), body(), spec());
    case 7: return impulse(body(), {random.uniform(-1, 1), 0.3, 0.1}, {0, random.uniform(-1, 1), 0}, {0.1, 0.2, 0});
    case 8: return set_parameters(joint(), {.damping = 0.1, .armature = random.uniform(0, 0.1)});
    default: return lock(joint(), {0});
  }
}

}  // namespace

TEST_CASE("certificates: every body's momentum changes by the impulses of its joints; momenta and energies balance") {
  int done = 0, impacts = 0, refusals = 0;
  double worst_body = 0, worst_ground = 0, worst_energy = 0;
  for (std::uint64_t seed = 0; seed < 250; ++seed) {
    Prng random(seed * 31 + 7);
    oracle::RandomTreeOptions options;
    options.max_bodies = 9, options.several_mechanisms = true, options.all_free = seed % 3 == 0;
    Simulation sim(oracle::random_tree(seed, options).model);
    const World& world = sim.world();
    const Model& model = world.model();
    for (int k = 0; k < 8; ++k) {
      std::vector<Action> actions;
      for (int i = random.integer(1, 3); i > 0; --i) actions.push_back(random_action(random, world));
      std::vector<Momentum> before;
      for (int b = 0; b < model.size(); ++b)
        before.push_back(momentum_of(model[{b}], world.motions()[static_cast<std::size_t>(b)]));
      const double error_before = sim.energy().error;
      Vec3 pushed{}, turned{};
      std::unordered_map<int, Momentum> outside;
      try {
        sim.apply(actions);
      } catch (const Error& refusal) {
        // Refusals for lack of mass must be justified: these trees are sound, except between two changes of one instant.
        if (refusal.problem.find("to move freely") != std::string::npos)
          CHECK(refusal.problem.find("impact with other actions") != std::string::npos);
        ++refusals;
        continue;
      }
      ++done;
      const Event& e = sim.events().back();
      // Impulses act after all topology changes: the poses are the present ones.
      for (const Action& action : actions) {
        if (action->key() != "impulse") continue;
        std::string name;
        Vec3 force, torque, point;
        const_cast<ActionBase&>(*action).arguments([&](const Argument& each) {
          const std::string_view key = each.key;
          if (const auto* body = each.as<argument::Body>()) name = body->name;
          if (const Vec3* value = each.as<Vec3>()) (key == "force" ? force : key == "torque" ? torque : point) = *value;
        });
        const int b = model.body(name).index;
        const Vec3 at = world.motions()[static_cast<std::size_t>(b)].pose * point;
        Momentum& sum = outside[b];
        sum.linear += force, sum.angular += torque + cross(at, force);
        pushed += force, turned += torque + cross(at, force);
      }
      double scale = 1e-3;
      std::vector<Momentum> given(static_cast<std::size_t>(model.size()));
      Vec3 ground_linear{}, ground_angular{};
      for (const auto& [name, S] : e.impulse) {
        const int number = world.find_joint(name);
        REQUIRE(number >= 0);
        const JointView joint = world.joint({number});
        const Pose& pose = world.motions()[static_cast<std::size_t>(joint.child.index)].pose;
        const Mat3 R = rotation_matrix(pose.rotation);
        const Vec3 l = R * Vec3{S[0], S[1], S[2]}, h = R * Vec3{S[3], S[4], S[5]} + cross(pose.position, l);
        given[static_cast<std::size_t>(joint.child.index)].linear += l;
        given[static_cast<std::size_t>(joint.child.index)].angular += h;
        if (joint.parent == ground) {
          ground_linear += l, ground_angular += h;
        } else {
          given[static_cast<std::size_t>(joint.parent.index)].linear -= l;
          given[static_cast<std::size_t>(joint.parent.index)].angular -= h;
        }
        scale = std::max({scale, norm(l), norm(h)});
      }
      for (int b = 0; b < model.size(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        const Momentum now = momentum_of(model[{b}], world.motions()[i]);
        scale = std::max({scale, norm(now.linear), norm(now.angular), norm(before[i].linear), norm(before[i].angular)});
      }
      for (int b = 0; b < model.size(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        const Momentum now = momentum_of(model[{b}], world.motions()[i]);
        const Momentum push = outside.contains(b) ? outside[b] : Momentum{};
        worst_body = std::max({worst_body, norm(now.linear - before[i].linear - given[i].linear - push.linear) / scale,
                               norm(now.angular - before[i].angular - given[i].angular - push.angular) / scale});
      }
      const Vec3 at_ground{e.ground_impulse[0], e.ground_impulse[1], e.ground_impulse[2]};
      const Vec3 turning{e.ground_impulse[3], e.ground_impulse[4], e.ground_impulse[5]};
      worst_ground = std::max({worst_ground, norm(ground_linear - at_ground) / scale, norm(ground_angular - turning) / scale,
                               norm(e.after.linear - e.before.linear - at_ground - pushed) / scale,
                               norm(e.after.angular - e.before.angular - turning - turned) / scale});
      worst_energy = std::max(worst_energy, std::fabs(sim.energy().error - error_before) /
                                                (1e-3 + std::fabs(e.before.kinetic) + std::fabs(e.before.potential)));
      CHECK(e.lost > -1e-9 * (1 + e.before.kinetic));
      impacts += e.lost > 1e-6;
    }
  }
  MESSAGE(done, " events, ", impacts, " lossy, ", refusals, " refused; worst: body ", worst_body, ", ground ", worst_ground,
          ", energy ", worst_energy);
  CHECK(done > 500);
  CHECK(impacts > 150);
  CHECK(worst_body < 1e-9);
  CHECK(worst_ground < 1e-9);
  CHECK(worst_energy < 1e-10);
}

TEST_CASE("events of one instant: each certificate balances by itself, and begins where the previous one ended") {
  int done = 0, mixed = 0;
  double worst = 0, worst_link = 0;
  for (std::uint64_t seed = 0; seed < 900; ++seed) {
    Prng random(seed * 17 + 3);
    oracle::RandomTreeOptions options;
    options.max_bodies = 9, options.several_mechanisms = true, options.all_free = seed % 3 == 0;
    Simulation sim(oracle::random_tree(seed, options).model, {.step = 1e-4});
    std::vector<std::vector<std::string>> keys;
    for (int e = random.integer(2, 4); e > 0; --e) {
      Simulation::Scheduled scheduled = sim.at(1e-4);
      keys.emplace_back();
      for (int a = random.integer(1, 2); a > 0; --a) {
        const Action action = random_action(random, sim.world());
        if (sim.check(action)) continue;
        scheduled.then(action);
        keys.back().emplace_back(action->key());
      }
    }
    REQUIRE(sim.run_until(0.5e-4) == Status::ok);
    const Totals start = sim.world().totals();
    if (sim.run_until(1e-4) != Status::ok) continue;  // refused
    ++done;
    const std::vector<Event>& events = sim.events();
    REQUIRE(events.size() == keys.size());
    double scale = 1e-3 + std::fabs(start.kinetic) + std::fabs(start.potential);
    for (const Event& e : events) scale = std::max({scale, std::fabs(e.before.kinetic), e.lost, std::fabs(e.work)});
    for (std::size_t i = 0; i < events.size(); ++i) {
      const Event& e = events[i];
      const double gone = e.before.kinetic + e.before.potential - e.after.kinetic - e.after.potential;
      worst = std::max(worst, std::fabs(gone - e.lost - e.released + e.work) / scale);
      if (i == 0) continue;
      const Totals &end = events[i - 1].after, &begin = e.before;
      worst_link = std::max({worst_link, std::fabs(end.kinetic - begin.kinetic) / scale,
                             std::fabs(end.potential - begin.potential) / scale, norm(end.linear - begin.linear),
                             norm(end.angular - begin.angular)});
      mixed += events[i - 1].lost > 1e-6 && e.lost > 1e-6;
    }
    const Totals now = sim.world().totals();
    CHECK(events.back().after.kinetic == now.kinetic);
    CHECK(events.back().after.angular == now.angular);
  }
  MESSAGE(done, " instants, ", mixed, " pairs of lossy events; worst: certificate ", worst, ", link ", worst_link);
  CHECK(done > 150);
  CHECK(mixed > 20);
  CHECK(worst < 1e-10);
  CHECK(worst_link == 0);
}
