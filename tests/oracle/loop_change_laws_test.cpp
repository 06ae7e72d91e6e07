// Laws of topology changes of joints that close loops: each change of every kind, in both sets of variables, against the same
// change of the same ring whose loop another joint closes, so that the joint under test is one of the tree, in velocities. The
// impulses balance the bodies' momenta, energy is never gained, and the momenta of floating rings stay.
#include <tests/oracle/loop_ring.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

// What happens to the joint under test, and what is done afterwards.
struct Change {
  const char* name;
  std::vector<Action> (*first)(Prng& random, const Ring& ring);
  std::vector<Action> (*then)(Prng& random, const Ring& ring) = nullptr;
  bool frees = false;    // nothing but releases: no velocity changes
  bool strikes = false;  // impulses from outside
};

int dofs_under_test(const Ring& ring) { return info(ring.joints[static_cast<std::size_t>(ring.tested)].spec.kind).nv; }

std::vector<int> some_dofs(Prng& random, const Ring& ring) {
  const int nv = dofs_under_test(ring);
  if (nv == 0) return {};
  std::vector<int> dofs{random.integer(0, nv - 1)};
  if (nv > 1 && random.chance(0.3)) dofs.push_back((dofs[0] + 1) % nv);
  return dofs;
}
JointSpec other_joint(Prng& random) {
  JointSpec joint;
  do joint = random_joint(random, random_kind(random), {.parameters = false});
  while (joint.kind == Kind::free || joint.kind == Kind::weld);
  return joint;
}
// Another joint of the ring: of the tree in the first world, and the one that closes the loop in the second.
std::string other_name(const Ring& ring) { return Ring::name(ring.other); }
std::string bystander(Prng& random, const Ring& ring) {
  int k = 0;
  do k = random.integer(0, ring.size());
  while (k == ring.tested || k == ring.other);
  return Ring::name(k);
}
std::string base_name(const Ring& ring) { return ring.base ? "base" : "ground"; }

std::vector<Action> lock_all(Prng&, const Ring& ring) { return {lock(ring.under_test())}; }
std::vector<Action> unlock_all(Prng&, const Ring& ring) { return {unlock(ring.under_test())}; }
std::vector<Action> lock_some(Prng& random, const Ring& ring) { return {lock(ring.under_test(), some_dofs(random, ring))}; }
std::vector<Action> break_it(Prng&, const Ring& ring) { return {break_joint(ring.under_test())}; }
std::vector<Action> free_it(Prng&, const Ring& ring) { return {free_joint(ring.under_test())}; }
std::vector<Action> change_kind(Prng& random, const Ring& ring) { return {change_joint(ring.under_test(), random_kind(random))}; }
std::vector<Action> change_to_another(Prng& random, const Ring& ring) {
  return {change_joint(ring.under_test(), other_joint(random))};
}
std::vector<Action> change_to_ball(Prng&, const Ring& ring) { return {change_joint(ring.under_test(), Kind::ball)}; }
std::vector<Action> change_to_weld(Prng&, const Ring& ring) { return {change_joint(ring.under_test(), Kind::weld)}; }
std::vector<Action> lock_other(Prng&, const Ring& ring) { return {lock(other_name(ring))}; }
std::vector<Action> break_other(Prng&, const Ring& ring) { return {break_joint(other_name(ring))}; }
std::vector<Action> free_other(Prng&, const Ring& ring) { return {free_joint(other_name(ring))}; }
std::vector<Action> change_other(Prng& random, const Ring& ring) {
  return {change_joint(other_name(ring), random.chance(0.5) ? Kind::weld : Kind::cylindrical)};  // whichever body is its child
}
std::vector<Action> lock_both(Prng& random, const Ring& ring) {
  return {lock(ring.under_test(), some_dofs(random, ring)), lock(bystander(random, ring))};
}
std::vector<Action> lock_and_break_other(Prng& random, const Ring& ring) {
  return {break_joint(other_name(ring)), lock(ring.under_test(), some_dofs(random, ring))};
}
std::vector<Action> strike(Prng& random, const Ring& ring) {
  const Vec3 force = random.vector(2), torque = random.vector(0.5);
  return {impulse(Ring::body_name(random.integer(0, ring.size() - 1)), force, torque, random.vector(0.3))};
}
// Closes the ring again where the joint broke, in the poses that its bodies have by then.
std::vector<Action> close_again(Prng& random, const Ring& ring) {
  const int k = ring.tested, child = std::min(k, ring.size() - 1);
  const std::string to = k == 0 || k == ring.size() ? base_name(ring) : Ring::body_name(k - 1);
  if (random.chance(0.3)) return {weld(Ring::body_name(child), to)};
  const JointSpec spec = other_joint(random);
  if (random.chance(0.5)) return {attach(Ring::body_name(child), to, spec)};
  const Vec3 at = random.vector(0.4);
  return {attach(Ring::body_name(child), to, spec, Pose{at, random.rotation()})};
}

const Change changes[] = {{"lock", lock_all, unlock_all},
                          {"lock some DoFs", lock_some, unlock_all},
                          {"break, close again", break_it, close_again, true},
                          {"free", free_it, nullptr, true},
                          {"change the kind", change_kind},
                          {"change into another", change_to_another, change_to_another},
                          {"change into a ball joint", change_to_ball, lock_some},
                          {"weld", change_to_weld, change_to_another},
                          {"lock another joint", lock_other, lock_some},
                          {"break another joint", break_other, lock_some, true},
                          {"free another joint", free_other, break_it, true},
                          {"change another joint", change_other, lock_some},
                          {"lock two joints at once", lock_both, unlock_all},
                          {"break another joint and lock", lock_and_break_other, unlock_all},
                          {"strike a body", strike, lock_some, false, true}};

Integration accurately(Variables variables) { return {.method = "dop853", .variables = variables, .rtol = 1e-12, .atol = 1e-13}; }

struct Tally {
  int changes = 0, refused = 0, skipped = 0, lossy = 0, freed = 0, floating = 0, open = 0, runs = 0;
  double agreement = 0, balance = 0, gain = 0, waste = 0, momentum = 0, impulse = 0, energy = 0;
};

// A world before a change.
struct Before {
  std::vector<BodyMotion> motions;
  Totals totals;
  std::vector<Values> v;  // by joint of the ring
  explicit Before(const Ring& ring, const World& world) : motions(motions_of(world)), totals(world.totals()) {
    for (int k = 0; k <= ring.size(); ++k) {
      v.emplace_back();
      const int joint = world.find_joint(Ring::name(k));
      if (joint < 0) continue;
      for (const double x : world.joint({joint}).v) v.back().push_back(x);
    }
  }
};

Wrench impulse_through(const Event& event, std::string_view joint) {
  for (const auto& [name, x] : event.impulse)
    if (name == joint) return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  return {};
}

// The kinetic energy of the velocity jump, with armatures; the energy of those whose DoFs are locked is `released`.
double energy_of_jump(const Ring& ring, const World& world, const Before& before) {
  double twice = 0;
  for (int b = 0; b < world.model().size(); ++b) {
    const auto i = static_cast<std::size_t>(b);
    const BodySpec& body = world.model()[BodyId{b}];
    const Vec3 dv = velocity_of(world.motions()[i], body.com) - velocity_of(before.motions[i], body.com);
    const Eigen::Vector3d dw = eigen(world.motions()[i].angular - before.motions[i].angular);
    twice += body.mass * dot(dv, dv) + dw.dot(world_inertia(world, {b}) * dw);
  }
  for (int k = 0; k <= ring.size(); ++k) {
    const int number = world.find_joint(Ring::name(k));
    if (number < 0) continue;
    const JointView joint = world.joint({number});
    const Values& v = before.v[static_cast<std::size_t>(k)];
    for (int i = 0; joint.parameters != nullptr && i < v.size() && v.size() == static_cast<int>(joint.v.size()); ++i) {
      if ((joint.locked >> i & 1u) != 0) continue;
      const double dv = joint.v[static_cast<std::size_t>(i)] - v[i];
      twice += joint.parameters->armature.of(i) * dv * dv;
    }
  }
  return twice / 2;
}

// The laws of one event in one world.
void check_event(const Ring& ring, const Change& change, bool first, const Event& event, const World& world, const Before& before,
                 Tally& all) {
  const Totals after = world.totals();
  const double size = 1e-3 + before.totals.kinetic + after.kinetic;
  const bool strikes = change.strikes && first;
  if (!strikes) {
    const double gain = (after.kinetic - before.totals.kinetic) / size;
    CHECK(gain < 1e-12);
    all.gain = std::max(all.gain, gain);
    CHECK(event.lost > -1e-12 * size);
    const double total = before.totals.kinetic + before.totals.potential - after.kinetic - after.potential;
    const double balance = std::fabs(total - event.lost - event.released) / (size + std::fabs(after.potential));
    CHECK(balance < 1e-12);
    all.energy = std::max(all.energy, balance);
    if (event.actions.size() == 1) {  // of two locks, the second one releases what the first one left of its armature's energy
      const double waste = std::fabs(event.lost - energy_of_jump(ring, world, before)) / size;
      CHECK(waste < 1e-9);
      all.waste = std::max(all.waste, waste);
    }
    Momenta gains = momenta_of(world, world.motions());
    const Momenta then = momenta_of(world, before.motions);
    for (std::size_t b = 0; b < gains.linear.size(); ++b) gains.linear[b] -= then.linear[b], gains.angular[b] -= then.angular[b];
    const double left = unbalanced(world, gains, [&](JointId joint) { return impulse_through(event, world.joint_name(joint)); });
    CHECK(left < 1e-9);
    all.balance = std::max(all.balance, left);
  }
  all.lossy += event.lost > 1e-6 * size ? 1 : 0;
  if (change.frees && first) {
    double moved = 0;
    for (std::size_t b = 0; b < before.motions.size(); ++b)
      keep_larger(moved, norm(world.motions()[b].linear - before.motions[b].linear) +
                             norm(world.motions()[b].angular - before.motions[b].angular));
    CHECK(moved < 1e-11);
    CHECK(std::fabs(event.lost) < 1e-11 * size);
    ++all.freed;
  }
  if (ring.base && !strikes) {
    ++all.floating;
    const double off = norm(after.linear - before.totals.linear) / (1 + norm(after.linear)) +
                       norm(after.angular - before.totals.angular) / (1 + norm(after.angular));
    CHECK(off < 1e-12);
    all.momentum = std::max(all.momentum, off);
  }
}

// The same change in both worlds. Returns false if it was refused.
bool change_both(const Ring& ring, const Change& change, bool first, const std::vector<Action>& actions, Simulation& one,
                 Simulation& other, Tally& all) {
  const Before before(ring, one.world());
  const std::string name = first ? "first" : ring.under_test();  // a joint that is made gets the name of the broken one
  const RunResult a = one.try_apply(actions, name), b = other.try_apply(actions, name);
  REQUIRE_MESSAGE(bool(a) == bool(b), a.reason, " | ", b.reason);
  if (!a) {
    ++all.refused;
    return false;
  }
  ++all.changes;
  const World &world = one.world(), &twin = other.world();
  const Event &e = one.events().back(), &f = other.events().back();
  CHECK(e.action_texts() == f.action_texts());
  check_event(ring, change, first, e, world, before, all);
  const double size = 1 + e.before.kinetic;
  CHECK(std::fabs(e.lost - f.lost) < 1e-9 * size);
  CHECK(std::fabs(e.released - f.released) < 1e-9 * size);
  CHECK(std::fabs(e.work - f.work) < 1e-9 * size);
  for (int k = 0; k <= ring.size(); ++k) {
    const JointId joint{world.find_joint(Ring::name(k))};
    if (joint.index < 0) continue;
    if (!world.joint_forces(joint).determined) {
      ++all.open;
      continue;
    }
    const Wrench x = in_world(ring, world, k, impulse_through(e, Ring::name(k)));
    const Wrench y = in_world(ring, twin, k, impulse_through(f, Ring::name(k)));
    const double difference = apart(x, y) / (1 + size_of(x));
    CHECK(difference < 1e-8);
    all.impulse = std::max(all.impulse, difference);
  }
  const double agreement = disagreement(ring, world, twin);
  CHECK(agreement < 1e-7);
  all.agreement = std::max(all.agreement, agreement);
  CHECK(newton_euler_error(world) < 1e-9);
  CHECK(power_error(world) < 1e-9);
  return true;
}

}  // namespace

TEST_CASE("loop joints: each change of topology, of every kind") {
  Tally all;
  std::uint64_t number = 0;
  for (const Kind kind : loop_kinds())
    for (const Change& change : changes)
      for (const Variables variables : {Variables::velocities, Variables::momenta})
        for (std::uint64_t seed = 0; seed < 4; ++seed, ++number) {
          const std::string about = std::string(info(kind).name) +
                                    (variables == Variables::momenta ? " in momenta: " : " in velocities: ") + change.name;
          CAPTURE(about);
          CAPTURE(seed);
          CAPTURE(number);
          RingOptions options{.tested = kind, .floating = seed % 2 == 1, .mobility = 3};
          if (seed % 4 > 1)
            options.give = [](Prng& random, JointSpec& joint, const Values&) {
              for (int i = 0; i < info(joint.kind).nv; ++i) {
                joint.parameters.stiffness.push_back(random.uniform(0, 5));
                joint.parameters.damping.push_back(random.uniform(0, 0.5));
              }
            };
          const Ring ring = random_ring(number, options);
          Simulation one(ring.as_loop(), accurately(variables)), other(ring.as_tree(), accurately(Variables::velocities));
          Prng random(number + 5000);
          if (!change_both(ring, change, true, change.first(random, ring), one, other, all)) continue;
          if (number % 3 == 0) {
            if (!one.run_until(0.05) || !other.run_until(0.05)) continue;
            ++all.runs;
            const double apart_by = disagreement(ring, one.world(), other.world());
            CHECK(apart_by < 1e-6);
            CHECK(balance_error(one) < 1e-8);
          }
          if (change.then != nullptr) change_both(ring, change, false, change.then(random, ring), one, other, all);
        }
  MESSAGE(all.changes << " changes, " << all.refused << " refused, " << all.lossy << " lossy, " << all.freed << " releases, "
                      << all.floating << " floating, " << all.open << " open impulses, " << all.runs << " runs");
  CHECK(all.changes > 1500);
  CHECK(all.refused < 100);
  CHECK(all.lossy > 600);
  CHECK(all.freed > 200);
  CHECK(all.floating > 600);
  CHECK(all.runs > 200);
  MESSAGE("worst: agreement " << all.agreement << ", balance " << all.balance << ", gain " << all.gain << ", waste " << all.waste
                              << ", momentum " << all.momentum << ", impulses " << all.impulse << ", energy " << all.energy);
}
