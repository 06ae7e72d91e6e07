// Simulations that advance together in lanes, compared with the same simulations alone.
#include <momentree/batch/lockstep.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

constexpr Isa all_sets[] = {Isa::baseline, Isa::avx2, Isa::avx512};

// A tree of eight bodies that start differently in each world. `form`: of several models.
Model model_of(int form, double turn) {
  Model model({.gravity = form == 3 ? Vec3{0, 0, -1.6} : Vec3{0, 0, -9.81}});
  BodyId last = ground;
  for (int k = 0; k < 8; ++k) {
    BodySpec body{.name = "m/" + std::to_string(k),
                  .mass = 0.5 + 0.1 * k,
                  .com = {0.1, 0.02, -0.03},
                  .inertia = {0.01, 0.012, 0.013, 0.001, 0, 0.0005},
                  .parent = k == 5 ? BodyId{2} : last,
                  .at = {0.2, 0.05, 0}};
    if (k == 3)
      body.joint = Ball{.damping = 0.02, .stiffness = 0.3}, body.q = {1, 0, 0, 0};
    else if (k == 5)
      body.joint = Prismatic{.axis = {1, 0, 0.2}, .stiffness = 20.0, .rest = 0.1}, body.q = 0.05;
    else
      body.joint = Revolute{.axis = {1.0 - 0.3 * k, 0.2 * k, 1}, .damping = 0.01, .effort = form == 1 && k == 1 ? 0.2 : 0.1},
      body.q = 0.3 + turn + 0.1 * k, body.v = 1 - 0.4 * k;
    if (k == 4) body.joint.parameters.drive = effort_drive({Signal::sine(form == 2 ? 0.3 : 0.2, 2)});
    if (k == 6)
      body.joint = Revolute{.axis = y_axis, .drive = motion_drive(Signal::table({{0, 0}, {0.113, 0.2}, {0.3, -0.1}, {1, 0}}))},
      body.q = {}, body.v = {};
    if (k == 2) body.joint.parameters.friction = JointFriction{.coulomb = 0.05, .speed = 0.1};
    last = model.add(body);
  }
  return model;
}

// A simulation with what was seen of it.
struct Case {
  std::unique_ptr<Simulation> simulation;
  std::vector<double> looked, sampled;
  explicit Case(int number) {  // two of four in velocities
    std::mt19937 random(static_cast<unsigned>(number));
    const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
    const Model model = model_of(number % 9 == 8 ? 1 + number % 3 : 0, uniform(-0.2, 0.2));
    const Variables variables = number / 2 % 2 == 0 ? Variables::momenta : Variables::velocities;
    simulation = std::make_unique<Simulation>(model, Integration{.method = "rk4", .variables = variables, .step = 2e-3});
    Simulation& sim = *simulation;
    if (number % 2 == 0) sim.at(uniform(0.02, 0.4)).then(break_joint("m/" + std::to_string(1 + number / 2 % 4))).named("part");
    if (number % 3 == 0) sim.at(uniform(0.02, 0.4)).then(lock("m/0"));
    if (number % 4 == 0) sim.every(0.1, 0.05).then(impulse("m/1", {0.01, 0, 0.02}));
    if (number % 5 == 0) sim.when(position_of("m/1").exceeds(0.9)).then(lock("m/1")).named("low");
    if (number % 7 == 0) sim.observe(0.017, [this](const World& world) { return looked.push_back(world.time()), true; });
    if (number % 6 == 0) sim.sample([this](const World& world) { return sampled.push_back(world.totals().kinetic), true; });
  }
};

std::vector<double> numbers_of(const Simulation& sim) {
  std::vector<double> all = {sim.time()};
  const State& state = sim.world().state();
  all.insert(all.end(), state.q().begin(), state.q().end());
  all.insert(all.end(), state.y().begin(), state.y().end());
  for (const Event& event : sim.events()) all.insert(all.end(), {event.time, event.lost, event.after.kinetic});
  all.push_back(static_cast<double>(sim.statistics().steps));
  return all;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(a[i] - b[i]) / std::fmax(1, std::fabs(a[i])));
  return worst;
}

std::vector<std::unique_ptr<Case>> cases(const std::vector<int>& numbers) {
  std::vector<std::unique_ptr<Case>> all;
  for (const int number : numbers) all.push_back(std::make_unique<Case>(number));
  return all;
}

void run(Lockstep& lockstep, const std::vector<std::unique_ptr<Case>>& all, double until) {
  std::vector<LockstepRun> runs;
  for (const auto& each : all) runs.push_back({each->simulation.get(), until});
  lockstep.run(runs);
  for (const LockstepRun& each : runs) {
    CAPTURE(each.result.reason);
    CHECK(each.result);
    CHECK(each.simulation->result().status == Status::ok);
  }
}

}  // namespace

TEST_CASE("simulations in lanes have the bits of those alone, whatever runs beside them") {
  constexpr int count = 90;
  std::vector<int> numbers(count);
  for (int i = 0; i < count; ++i) numbers[static_cast<std::size_t>(i)] = i;
  auto alone = cases(numbers);
  for (const auto& each : alone)
    for (const double until : {0.15, 0.5}) REQUIRE(each->simulation->run_until(until) == Status::ok);
  for (const Isa isa : all_sets) {
    if (!batch::available(isa)) continue;
    CAPTURE(static_cast<int>(isa));
    Lockstep lockstep(isa);
    const auto together = cases(numbers);
    int fit = 0;
    for (const auto& each : together) fit += Lockstep::fits(*each->simulation);
    CHECK(fit == count - count / 5);  // those without a condition
    for (const double until : {0.15, 0.5}) run(lockstep, together, until);
    for (std::size_t i = 0; i < count; ++i) {
      CAPTURE(i);
      // On x86-64 there is no machine code for the baseline.
      const double off = batch::makes_machine_code(isa) == batch::makes_machine_code(std::nullopt) ? 0 : 1e-10;
      CHECK(difference(numbers_of(*alone[i]->simulation), numbers_of(*together[i]->simulation)) <= off);
      CHECK(alone[i]->looked == together[i]->looked);
      CHECK(difference(alone[i]->sampled, together[i]->sampled) <= off);
      for (std::size_t e = 0; e < alone[i]->simulation->events().size(); ++e)
        CHECK(alone[i]->simulation->events()[e].name == together[i]->simulation->events()[e].name);
    }
    std::vector<int> shuffled = numbers;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(7));
    for (std::size_t first = 0, size = 1; first < count; first += size, size = size % 13 + 1) {
      const std::vector<int> some(shuffled.begin() + static_cast<std::ptrdiff_t>(first),
                                  shuffled.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(first + size, count)));
      const auto others = cases(some);
      for (const double until : {0.15, 0.5}) run(lockstep, others, until);
      for (std::size_t i = 0; i < some.size(); ++i)
        CHECK(numbers_of(*others[i]->simulation) == numbers_of(*together[static_cast<std::size_t>(some[i])]->simulation));
    }
  }
}

TEST_CASE("the number of lanes is that of the steppers") {
  const Tree tree = compile(model_of(0, 0));
  for (const Isa isa : all_sets)
    for (const Variables variables : {Variables::momenta, Variables::velocities})
      if (batch::available(isa))
        CHECK(Lockstep(isa).lanes() == batch::make_stepper(isa, Precision::float64, tree, variables)->lanes());
}

TEST_CASE("what ends a run alone ends it in lanes") {
  Lockstep lockstep;
  const auto both = [&](const char* what, double until, Status status, auto prepare) {
    CAPTURE(what);
    for (const Variables variables : {Variables::momenta, Variables::velocities}) {
      const Integration how{.method = "rk4", .variables = variables, .step = 2e-3};
      Simulation alone(model_of(0, 0.1), how), lane(model_of(0, 0.1), how), beside(model_of(0, 0.3), how);
      prepare(alone), prepare(lane);
      LockstepRun runs[] = {{&beside, 0.4}, {&lane, until}};
      lockstep.run(runs);
      const RunResult expected = alone.run_until(until);
      CHECK(runs[0].result);
      CHECK(beside.time() == 0.4);
      CHECK(expected.status == status);
      CHECK(runs[1].result.status == status);
      CHECK(runs[1].result.reason.substr(0, 25) == expected.reason.substr(0, 25));  // numbers of a divergence are noise
      CHECK(difference(numbers_of(alone), numbers_of(lane)) < 1e-10);
    }
  };
  both("nothing", 0.2, Status::ok, [](Simulation&) {});
  both("a time that is past", 0, Status::ok, [](Simulation&) {});
  both("a sampler", 0.2, Status::interrupted,
       [](Simulation& sim) { sim.sample([](const World& world) { return world.time() < 0.1; }); });
  both("an observer", 0.2, Status::interrupted,
       [](Simulation& sim) { sim.observe(0.03, [](const World& world) { return world.time() < 0.1; }); });
  both("an impossible action", 0.2, Status::refused, [](Simulation& sim) {
    sim.at(0.1).then(break_joint("m/1"));
    sim.at(0.12).then(impulse("m/1", {NAN, 0, 0}));
  });
  both("a divergence", 0.2, Status::diverged, [](Simulation& sim) { sim.at(0.1).then(impulse("m/0", {}, {1e14, 1e14, 1e14})); });
}

TEST_CASE("simulations that change after each step are not run in lanes") {
  const auto fits = [](const Integration& how, auto prepare) {
    Simulation sim(model_of(0, 0), how);
    prepare(sim);
    return Lockstep::fits(sim);
  };
  const Integration rk4{.method = "rk4"};
  CHECK(fits(rk4, [](Simulation&) {}));
  CHECK(fits({.method = "rk4", .variables = Variables::velocities}, [](Simulation&) {}));
  CHECK_FALSE(fits({.method = "dopri5"}, [](Simulation&) {}));
  CHECK_FALSE(fits(rk4, [](Simulation& sim) { sim.when(position_of("m/1").exceeds(5)).then(lock("m/0")); }));
  CHECK_FALSE(fits(rk4, [](Simulation& sim) { sim.drive("m/0", [](const EvaluationContext&) { return 0.1; }); }));
  CHECK_FALSE(fits(rk4, [](Simulation& sim) { sim.force("m/0", [](const EvaluationContext&) { return Wrench{}; }); }));
}
