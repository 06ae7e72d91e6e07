// Laws of joints that close loops: every kind that a loop joint can be, with every parameter, in both sets of variables. The
// same ring of bodies is built twice: closed by the joint under test, and closed by another joint, so that the joint under test
// is one of the tree, in velocities. Accelerations, reactions, energies and events must agree, and each world obeys the laws of
// mechanics by itself.
#include <tests/oracle/loop_ring.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

// A parameter of joints.
struct Feature {
  const char* name;
  bool (*suits)(const KindInfo& kind);
  void (*give)(Prng& random, JointSpec& joint, const Values& q);
  bool smooth = true;  // false: forces jump, of which the quadrature of the energy balance takes notice
};

bool moves(const KindInfo& kind) { return kind.nv > 0; }
bool has_rates(const KindInfo& kind) { return kind.nv > 0 && kind.nq == kind.nv; }  // velocities are rates of coordinates
bool single(const KindInfo& kind) { return kind.nv == 1; }

Values some(Prng& random, int count, double low, double high) {
  Values values;
  for (int i = 0; i < count; ++i) values.push_back(random.chance(0.7) ? random.uniform(low, high) : 0.0);
  return values;
}
std::vector<Signal> signals(Prng& random, int count, double amplitude) {
  std::vector<Signal> all;
  for (int i = 0; i < count; ++i) {
    const double size = random.uniform(0.1, amplitude), frequency = random.uniform(0.5, 2), offset = random.uniform(-1, 1);
    all.push_back(Signal::sine(size, frequency, random.uniform(-3, 3), offset));
  }
  return all;
}

void give_spring(Prng& random, JointSpec& joint, const Values& q) {
  joint.parameters.stiffness = some(random, info(joint.kind).nv, 1, 20);
  if (!has_rates(info(joint.kind)) || random.chance(0.3)) return;
  for (const double x : q) joint.parameters.rest.push_back(x + random.uniform(-0.3, 0.3));
}
void give_damping(Prng& random, JointSpec& joint, const Values&) {
  joint.parameters.damping = some(random, info(joint.kind).nv, 0.1, 2);
}
void give_friction(Prng& random, JointSpec& joint, const Values&) {
  joint.parameters.friction.coulomb = some(random, info(joint.kind).nv, 0.1, 2);
  joint.parameters.friction.speed = random.uniform(0.1, 0.5);
}
void give_effort(Prng& random, JointSpec& joint, const Values&) {
  joint.parameters.effort = some(random, info(joint.kind).nv, -5, 5);
}
void give_signals(Prng& random, JointSpec& joint, const Values&) {
  joint.parameters.drive = effort_drive(signals(random, info(joint.kind).nv, 4));
}
void give_control(Prng& random, JointSpec& joint, const Values&) {
  const int nv = info(joint.kind).nv;
  JointDrive::Pd pd;
  pd.kp = some(random, nv, 1, 20), pd.kd = some(random, nv, 0.1, 2);
  pd.target = signals(random, nv, 0.5);
  if (random.chance(0.5)) pd.max_effort = random.uniform(2, 50);
  joint.parameters.drive = pd_drive(pd);
}
void give_soft_stops(Prng& random, JointSpec& joint, const Values& q) {
  JointLimits& limits = joint.parameters.limits;
  for (const double x : q) limits.lower.push_back(x + random.uniform(-0.2, 0.05));
  for (int i = 0; i < q.size(); ++i) limits.upper.push_back(limits.lower[i] + random.uniform(0.05, 0.3));
  limits.stiffness = random.uniform(10, 100), limits.damping = random.uniform(0, 2);
}
void give_hard_stops(Prng& random, JointSpec& joint, const Values& q) {
  JointLimits& limits = joint.parameters.limits;
  for (const double x : q) {
    limits.lower.push_back(x - random.uniform(0.01, 0.15)), limits.upper.push_back(x + random.uniform(0.01, 0.15));
    limits.restitution.push_back(random.chance(0.5) ? 0.0 : random.uniform(0, 0.8));
  }
}
void give_armature(Prng& random, JointSpec& joint, const Values&) {
  for (int i = 0; i < info(joint.kind).nv; ++i)
    joint.parameters.armature.push_back(random.chance(0.7) ? random.log_uniform(0.05, 7) : 0.0);
}
void give_motion(Prng& random, JointSpec& joint, const Values& q) {
  const double amplitude = random.uniform(0.1, 0.3), phase = random.uniform(-1, 1);
  joint.parameters.drive = motion_drive(Signal::sine(amplitude, 0.5, phase, q[0] - amplitude * std::sin(phase)));
}
void give_all(Prng& random, JointSpec& joint, const Values& q) {
  give_spring(random, joint, q), give_damping(random, joint, q), give_friction(random, joint, q);
  give_effort(random, joint, q), give_signals(random, joint, q);
}

const Feature nothing{"nothing", [](const KindInfo&) { return true; }, [](Prng&, JointSpec&, const Values&) {}};
const Feature features[] = {nothing,
                            {"spring", moves, give_spring},
                            {"damping", moves, give_damping},
                            {"friction", moves, give_friction},
                            {"effort", moves, give_effort},
                            {"effort signals", moves, give_signals},
                            {"position control", has_rates, give_control, false},
                            {"soft stops", has_rates, give_soft_stops, false},
                            {"spring, damping, friction and efforts", moves, give_all},
                            {"armature", moves, give_armature},
                            {"prescribed motion", single, give_motion}};

Integration accurately(Variables variables) { return {.method = "dop853", .variables = variables, .rtol = 1e-12, .atol = 1e-13}; }

std::string text(Kind kind, Variables variables) {
  return info(kind).name + std::string(variables == Variables::momenta ? " in momenta" : " in velocities");
}

// Calls law(ring options, variables, feature) for every kind and feature.
template <class Law>
void for_every_feature(const Law& law) {
  for (const Kind kind : loop_kinds())
    for (const Feature& feature : features)
      for (const Variables variables : {Variables::velocities, Variables::momenta}) {
        if (!feature.suits(info(kind))) continue;
        const std::string about = text(kind, variables) + ": " + feature.name;
        CAPTURE(about);
        RingOptions options;
        options.tested = kind, options.give = feature.give;
        law(options, variables, feature);
      }
}

// Rows that are nearly dependent, where rounding is amplified.
bool ill_conditioned(const World& one, const World& other) {
  return nearly_singular(rows_of(one)) || nearly_singular(rows_of(other));
}

struct Worst {
  double agreement = 0, newton = 0, effort = 0, power = 0;
  int worlds = 0, open = 0, singular = 0;
};

// All laws of two worlds at an instant.
void check_laws(const Ring& ring, const World& one, const World& other, double tolerance, Worst& worst, bool least = false) {
  const double agreement = disagreement(ring, one, other, least);
  CHECK(agreement < tolerance);
  const double newton = newton_euler_error(one);
  CHECK(newton < 1e-10);
  const double power = power_error(one);
  CHECK(power < 1e-10);
  double effort = 0;
  for (int k = 0; k <= ring.size(); ++k) {
    const JointId joint{one.find_joint(Ring::name(k))}, twin{other.find_joint(Ring::name(k))};
    if (joint.index < 0) continue;
    keep_larger(effort, effort_error(one, joint, is_loop(joint) ? other.joint_forces(twin).a : one.joint_forces(joint).a));
    worst.open += one.joint_forces(joint).determined ? 0 : 1;
  }
  CHECK(effort < 10 * tolerance);
  ++worst.worlds;
  worst.agreement = std::max(worst.agreement, agreement), worst.newton = std::max(worst.newton, newton);
  worst.effort = std::max(worst.effort, effort), worst.power = std::max(worst.power, power);
}

std::string text(const Worst& w) {
  return std::to_string(w.worlds) + " worlds, " + std::to_string(w.open) + " open reactions, " + std::to_string(w.singular) +
         " singular; worst agreement " + std::to_string(std::log10(w.agreement)) + ", Newton " +
         std::to_string(std::log10(w.newton)) + ", effort " + std::to_string(std::log10(w.effort)) + ", power " +
         std::to_string(std::log10(w.power)) + " (decimal digits)";
}

}  // namespace

TEST_CASE("loop joints: accelerations, reactions and power, with every parameter of every kind") {
  Worst worst;
  for_every_feature([&](RingOptions& options, Variables variables, const Feature&) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      CAPTURE(seed);
      options.floating = seed % 3 == 2, options.coupled = seed % 5 == 4;
      const Ring ring = random_ring(seed + 100 * static_cast<std::uint64_t>(options.tested), options);
      const World one(ring.as_loop(), variables, variables), other(ring.as_tree(), Variables::velocities);
      if (ill_conditioned(one, other)) {
        ++worst.singular;
        continue;
      }
      REQUIRE(one.state().variables() == variables);
      CHECK(is_loop({one.find_joint(ring.under_test())}));
      CHECK_FALSE(is_loop({other.find_joint(ring.under_test())}));
      check_laws(ring, one, other, 1e-9, worst);
    }
  });
  MESSAGE(text(worst));
  CHECK(worst.worlds > 800);
  CHECK(worst.singular < worst.worlds / 50);
}

TEST_CASE("loop joints: redundant equations leave the same reactions open, and the least of them are the same") {
  Worst worst;
  for_every_feature([&](RingOptions& options, Variables variables, const Feature&) {
    if (options.tested == Kind::helical) return;  // holds the ring: its axis would have to lie in the plane
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      CAPTURE(seed);
      options.planar = true, options.floating = seed % 2 == 1;
      const Ring ring = random_ring(seed, options);
      const World one(ring.as_loop(), variables, variables), other(ring.as_tree(), Variables::velocities);
      if (ill_conditioned(one, other)) {
        ++worst.singular;
        continue;
      }
      CHECK(one.loop_status().rank < one.loop_status().rows);
      check_laws(ring, one, other, 1e-9, worst, true);
    }
  });
  MESSAGE(text(worst));
  CHECK(worst.worlds > 300);
  CHECK(worst.open > 1000);
}

TEST_CASE("loop joints: runs agree and keep the balance of energy, with every parameter of every kind") {
  int runs = 0, refused = 0;
  double apart = 0, balance = 0, drift = 0;
  for_every_feature([&](RingOptions& options, Variables variables, const Feature& feature) {
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      CAPTURE(seed);
      options.floating = seed == 1;
      const Ring ring = random_ring(seed + 7 * static_cast<std::uint64_t>(options.tested) + 1000, options);
      Simulation one(ring.as_loop(), accurately(variables)), other(ring.as_tree(), accurately(Variables::velocities));
      if (ill_conditioned(one.world(), other.world())) continue;
      const Totals before = one.world().totals();
      if (!one.run_until(0.1) || !other.run_until(0.1)) {
        ++refused;
        continue;
      }
      ++runs;
      const double now = disagreement(ring, one.world(), other.world());
      CHECK(now < 1e-7);
      const EnergyBalance a = one.energy(), b = other.energy();
      const double size = 1 + a.largest_kinetic + std::fabs(a.work) + std::fabs(a.dissipated);
      const double bound = feature.smooth ? 1e-9 : 1e-4;
      CHECK(balance_error(one) < bound);
      CHECK(std::fabs(a.work - b.work) < bound * size);
      CHECK(std::fabs(a.dissipated - b.dissipated) < bound * size);
      apart = std::max(apart, now), balance = std::max(balance, feature.smooth ? balance_error(one) : 0);
      if (!ring.base) continue;
      const Totals after = one.world().totals();
      const double moved = norm(after.linear - before.linear) / (1 + norm(before.linear)) +
                           norm(after.angular - before.angular) / (1 + norm(before.angular));
      CHECK(moved < 1e-9);
      drift = std::max(drift, moved);
    }
  });
  MESSAGE(runs << " runs, " << refused << " failed; apart " << apart << ", balance " << balance << ", momentum " << drift);
  CHECK(runs > 200);
  CHECK(refused < 10);
}

// Compares the events of both worlds one by one.
namespace {
void check_events(const Simulation& one, const Simulation& other, double tolerance) {
  const std::vector<Event>&e = one.events(), &f = other.events();
  REQUIRE(e.size() == f.size());
  for (std::size_t i = 0; i < e.size(); ++i) {
    const double size = 1 + e[i].before.kinetic;
    CHECK(std::fabs(e[i].time - f[i].time) < 1e-8);
    REQUIRE(e[i].action_texts() == f[i].action_texts());
    CHECK(std::fabs(e[i].lost - f[i].lost) < tolerance * size);
    CHECK(e[i].lost > -1e-9 * size);
  }
}
}  // namespace

TEST_CASE("loop joints: hard stops") {
  int runs = 0, hits = 0, rests = 0, leaves = 0;
  for (const Kind kind : loop_kinds())
    for (const Variables variables : {Variables::velocities, Variables::momenta})
      for (std::uint64_t seed = 0; seed < 12; ++seed) {
        // The second angle of a universal loop joint does not count full turns.
        if (!has_rates(info(kind)) || kind == Kind::universal) continue;
        const std::string about = text(kind, variables);
        CAPTURE(about);
        CAPTURE(seed);
        RingOptions options{.tested = kind, .floating = seed % 3 == 1, .give = give_hard_stops};
        Ring ring = random_ring(seed + 50 * static_cast<std::uint64_t>(kind), options);
        Simulation one(ring.as_loop(), accurately(variables)), other(ring.as_tree(), accurately(Variables::velocities));
        if (!one.run_until(0.25) || !other.run_until(0.25)) continue;
        ++runs;
        check_events(one, other, 1e-7);
        for (const Event& event : one.events()) {
          const std::string& what = event.actions[0].kind;
          (what == "hit" ? hits : what == "rest" ? rests : leaves) += 1;
        }
        Worst worst;
        check_laws(ring, one.world(), other.world(), 1e-6, worst);
        CHECK(balance_error(one) < 1e-8);
        const JointView view = one.world().joint({one.world().find_joint(ring.under_test())});
        const JointLimits& limits = ring.joint_under_test().spec.parameters.limits;
        for (int i = 0; i < info(kind).nv; ++i) {
          CHECK(view.q[static_cast<std::size_t>(i)] > limits.lower[i] - 1e-9);
          CHECK(view.q[static_cast<std::size_t>(i)] < limits.upper[i] + 1e-9);
        }
      }
  MESSAGE(runs << " runs, " << hits << " hits, " << rests << " rests, " << leaves << " leaves");
  CHECK(runs > 100);
  CHECK(hits > 50);
  CHECK(rests > 20);
}

// The load on the joint rises; then it breaks at the same instant.
TEST_CASE("loop joints: strength") {
  int broken = 0;
  for (const Kind kind : loop_kinds())
    for (const Variables variables : {Variables::velocities, Variables::momenta})
      for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const std::string about = text(kind, variables);
        CAPTURE(about);
        CAPTURE(seed);
        Ring ring = random_ring(seed + 50 * static_cast<std::uint64_t>(kind), {.tested = kind, .floating = seed % 2 == 1});
        // From a run that does not break: halfway between the loads at its start and at its end.
        double loads[2] = {};
        Simulation whole(ring.as_tree(), accurately(Variables::velocities));
        for (double& load : loads) {
          load = norm(whole.world().joint_forces({whole.world().find_joint(ring.under_test())}).reaction.force);
          static_cast<void>(whole.run_until(0.1));
        }
        if (loads[1] < 1.05 * loads[0]) continue;
        ring.joint_under_test().spec.parameters.strength.force = (loads[0] + loads[1]) / 2;
        Simulation one(ring.as_loop(), accurately(variables)), other(ring.as_tree(), accurately(Variables::velocities));
        REQUIRE(one.run_until(0.15));
        REQUIRE(other.run_until(0.15));
        REQUIRE(one.events().size() == 1);
        ++broken;
        check_events(one, other, 1e-9);
        CHECK(one.world().loops().empty());
        CHECK(std::fabs(one.events()[0].lost) < 1e-9 * (1 + one.events()[0].before.kinetic));
        CHECK(disagreement(ring, one.world(), other.world()) < 1e-7);
        CHECK(balance_error(one) < 1e-8);
      }
  MESSAGE(broken << " joints broke");
  CHECK(broken > 25);
}
