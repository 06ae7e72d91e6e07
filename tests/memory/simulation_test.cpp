// Whole runs with changes give the same results to the last bit, whatever fresh memory contains: methods, changes, events, energy
// ledger, history.
#include <string>

#include <doctest/doctest.h>

#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/memory/bits.hpp>
#include <tests/memory/filled_memory.hpp>
#include <tests/memory/random_worlds.hpp>
#include <tests/oracle/prng.hpp>

namespace momentree::memory {

namespace {

struct Outcome {
  Bits bits;
  int changes = 0, refused = 0, undone = 0;
};

Action random_action(oracle::Prng& random, const std::string& body) {
  switch (random.integer(0, 7)) {
    case 0: return break_joint(body);
    case 1: return lock(body);
    case 2: return unlock(body);
    case 3: return free_joint(body);
    case 4: return impulse(body, random.vector(1), random.vector(0.1));
    case 5: return weld(body);
    case 6: return attach(body, "ground", Ball{});
    default: return change_joint(body, Kind::universal);
  }
}

void add(const World& world, Bits& bits) {
  for (const BodyMotion& motion : world.motions()) {
    bits.add(motion.pose.position), bits.add(motion.linear), bits.add(motion.angular);
    const Quat& r = motion.pose.rotation;
    bits.add(r.w), bits.add(r.x), bits.add(r.y), bits.add(r.z);
  }
  for (const BodyAcceleration& a : world.accelerations()) bits.add(a.linear), bits.add(a.angular);
  for (int joint = 0; joint < world.tree().bodies(); ++joint) {
    if (world.tree().carrier(joint) < 0) continue;
    const Wrench carried = world.reaction({joint});
    bits.add(carried.force), bits.add(carried.torque);
  }
}

void add(const EnergyBalance& e, Bits& bits) {
  for (const double x : {e.initial, e.final, e.dissipated, e.work, e.lost_in_impacts, e.released, e.error}) bits.add(x);
}

Outcome run(std::uint64_t seed, const std::string& method) {
  Outcome outcome;
  oracle::Prng random(seed + 5000);
  const Model model = random_model(seed);
  Simulation sim(model, {.method = method, .step = 1e-3, .rtol = 1e-6, .atol = 1e-8});
  sim.keep_history();
  if (seed % 2 == 0)
    sim.force(model[{0}].name, [](const EvaluationContext& context) { return Wrench{{context.time(), 0, 1}, {}}; });
  for (int k = 1; k <= 5; ++k) {
    outcome.bits.add(static_cast<double>(sim.run_until(2e-3 * k).status));
    add(sim.world(), outcome.bits);
    const BodyId body{random.integer(0, model.size() - 1)};
    const Action actions[] = {random_action(random, model[body].name)};
    if (sim.try_apply(actions) == Status::refused) ++outcome.refused;
  }
  const BodyId parent = sim.world().alive({0}) ? BodyId{0} : ground;
  const BodyId added =
      sim.add({.name = "added", .mass = 1, .inertia = diagonal(0.1), .parent = parent, .at = {0.1, 0, 0}, .joint = Ball{}});
  outcome.bits.add(static_cast<double>(sim.run_until(0.012).status));
  add(sim.world(), outcome.bits);
  sim.remove(added);
  for (const Event& event : sim.events()) {
    outcome.bits.add(event.lost), outcome.bits.add(event.released), outcome.bits.add(event.work);
    outcome.bits.add(event.ground_impulse.data(), 6);
    for (const auto& [joint, impulse] : event.impulse) outcome.bits.add(impulse.data(), 6);
  }
  outcome.changes = static_cast<int>(sim.events().size());
  add(sim.energy(), outcome.bits);
  Simulation branch = sim.branch();
  outcome.bits.add(static_cast<double>(branch.run_until(0.014).status));
  add(branch.world(), outcome.bits);
  if (!sim.events().empty() && sim.can_undo(0)) {
    sim.undo(0);
    ++outcome.undone;
  }
  outcome.bits.add(static_cast<double>(sim.run_until(sim.time() + 2e-3).status));
  add(sim.world(), outcome.bits);
  return outcome;
}

Outcome run(std::uint64_t seed, const std::string& method, Fill fill) {
  const Filled filled(fill);
  return run(seed, method);
}

}  // namespace

TEST_CASE("a run with changes does not depend on the contents of fresh memory") {
  const std::vector<std::string> methods = integration_methods();
  const int runs = off() ? 20 : 120;
  int changes = 0, refused = 0, undone = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(runs); ++seed) {
    CAPTURE(seed);
    const std::string& method = methods[seed % methods.size()];
    CAPTURE(method);
    const Outcome one = run(seed, method, Fill::quiet), other = run(seed, method, Fill::zeros);
    CHECK((one.bits == other.bits));
    changes += one.changes, refused += one.refused, undone += one.undone;
  }
  CHECK(changes > 2 * runs);
  CHECK(refused < changes);
  CHECK(undone > runs / 2);
}

}  // namespace momentree::memory
