#include <momentree/sweep/scenario_worlds.hpp>

#include <algorithm>
#include <exception>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/batch/lockstep.hpp>
#include <momentree/results/session.hpp>
#include <momentree/sweep/world_run.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::sweep {

namespace {

// Worlds of a thread that are in memory at once.
constexpr std::size_t most_together = 64;

WorldResult failed(std::string why) {
  WorldResult result;
  result.failure = why.empty() ? "it ended early" : std::move(why);
  return result;
}
WorldResult failed(const Error& error) { return failed(error.hint.empty() ? error.problem : error.problem + "; " + error.hint); }

// The scenario of a world. Throws Error if it cannot be read.
io::Scenario scenario_of(const Sweep& sweep, std::uint64_t world) {
  io::ReadResult read = io::read_scenario_again(*sweep.scenario, sweep.overrides(world));
  if (read.scenario) return std::move(*read.scenario);
  for (const io::Diagnostic& each : read.diagnostics)
    if (each.severity == io::Severity::error) {
      constexpr std::string_view set = "--set ";  // the value that is wrong
      const std::string value = each.file.starts_with(set) ? each.file.substr(set.size()) + ": " : "";
      throw_error({value + each.what, "", each.hint});
    }
  throw_error({"the scenario cannot be read", "", ""});
}

}  // namespace

// A world that is ready to run, or is running.
class ScenarioWorlds::Running {
 public:
  Running(const Sweep& sweep, std::uint64_t world, const std::atomic<bool>* stop)
      : session_(std::make_shared<const io::Scenario>(scenario_of(sweep, world))),
        warnings_(session_.schedule()),
        observation_(sweep.measures),
        run_(session_.simulation(), session_.scenario().until, sweep.stop, observation_) {
    // Steps end at the instants at which `run` writes rows, so that the same steps are made as in that run.
    if (session_.scenario().output_every > 0)
      simulation().observe(session_.scenario().output_every, [](const World&) { return true; });
    if (stop != nullptr) simulation().watch([this, stop](double) { return !(ended_ = stop->load(std::memory_order_relaxed)); });
  }

  Simulation& simulation() { return session_.simulation(); }
  WorldRun& run() { return run_; }
  void run_alone() {
    while (const std::optional<double> time = run_.next()) run_.reached(simulation().run_until(*time));
  }
  /// Whether it was told to end.
  bool ended() const { return ended_; }
  WorldResult result() {
    if (const RunResult outcome = run_.result(); !outcome) return failed(outcome.reason);
    WorldResult all;
    all.measures = observation_.results(simulation());
    return all;
  }

 private:
  io::Session session_;
  std::vector<io::Diagnostic> warnings_;
  Observation observation_;
  WorldRun run_;
  bool ended_ = false;
};

// Its result. What is thrown is its failure, except for a lack of memory.
WorldResult ScenarioWorlds::result_of(Running& world) {
  try {
    return world.result();
  } catch (const Error& error) {
    return failed(error);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return failed(error.what());
  }
}

// Worlds that run in lanes.
class ScenarioWorlds::Together {
 public:
  Together(Isa isa, const Take& take) : lockstep_(isa), take_(take) {}

  void add(std::size_t place, std::unique_ptr<Running> world) { worlds_.push_back({place, std::move(world)}); }
  bool full() const { return worlds_.size() >= most_together; }
  /// Runs them all; false: they were told to end.
  bool run() {
    for (;;) {
      std::vector<LockstepRun> runs;
      std::vector<WorldRun*> of;
      for (const Member& member : worlds_)
        if (const std::optional<double> time = member.world->run().next())
          runs.push_back({&member.world->simulation(), *time}), of.push_back(&member.world->run());
      if (runs.empty()) break;
      lockstep_.run(runs);
      for (std::size_t i = 0; i < runs.size(); ++i) of[i]->reached(runs[i].result);
    }
    const bool ended = std::any_of(worlds_.begin(), worlds_.end(), [](const Member& member) { return member.world->ended(); });
    for (const Member& member : worlds_)
      if (!ended) take_(member.place, result_of(*member.world));
    worlds_.clear();
    return !ended;
  }

 private:
  struct Member {
    std::size_t place;
    std::unique_ptr<Running> world;
  };
  Lockstep lockstep_;
  const Take& take_;
  std::vector<Member> worlds_;
};

ScenarioWorlds::ScenarioWorlds(const Sweep& sweep, Lanes lanes, const std::atomic<bool>* stop)
    : sweep_(sweep), lanes_(lanes), stop_(stop) {
  if (std::any_of(sweep.measures.begin(), sweep.measures.end(), needs_ledger)) lanes_.reset();
}

std::uint64_t ScenarioWorlds::at_once() const { return lanes_ ? static_cast<std::uint64_t>(Lockstep(*lanes_).lanes()) : 1; }

std::unique_ptr<ScenarioWorlds::Running> ScenarioWorlds::start(std::uint64_t world) const {
  return std::make_unique<Running>(sweep_, world, stop_);
}

bool ScenarioWorlds::fits(std::uint64_t world) const {
  try {
    return lanes_ && Lockstep::fits(start(world)->simulation());
  } catch (const Error&) {  // it cannot be run at all
    return false;
  }
}

bool ScenarioWorlds::gain_by_lanes() const {
  if (!fits(0)) return false;
  const std::unique_ptr<Running> first = start(0);
  if (!first->simulation().world().tree().has_loops()) return true;
  for (std::uint64_t world = 1; world < std::min(sweep_.worlds(), at_once()); ++world)
    if (fits(world) && Lockstep::share(first->simulation(), start(world)->simulation())) return true;
  return false;
}

bool ScenarioWorlds::run(std::span<const std::uint64_t> worlds, const Take& take) const {
  std::optional<Together> together;
  if (lanes_) together.emplace(*lanes_, take);
  for (std::size_t place = 0; place < worlds.size(); ++place) {
    if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) return false;
    try {
      std::unique_ptr<Running> world = start(worlds[place]);
      if (together && Lockstep::fits(world->simulation())) {
        together->add(place, std::move(world));
      } else {
        world->run_alone();
        if (world->ended()) return false;
        take(place, world->result());
      }
    } catch (const Error& error) {
      take(place, failed(error));
    } catch (const std::bad_alloc&) {
      throw_error({"out of memory", "world " + std::to_string(worlds[place]), "use fewer threads (--jobs), or smaller worlds"});
    } catch (const std::exception& error) {
      take(place, failed(error.what()));
    }
    if (together && together->full() && !together->run()) return false;
  }
  return !together || together->run();
}

WorldResult ScenarioWorlds::run(std::uint64_t world) const {
  WorldResult only = failed("it was ended");
  (void)run({&world, 1}, [&only](std::size_t, WorldResult result) { only = std::move(result); });
  return only;
}

std::string ScenarioWorlds::run(Chunk chunk) const {
  std::vector<std::uint64_t> worlds(chunk.count);
  std::iota(worlds.begin(), worlds.end(), chunk.first);
  std::vector<WorldResult> results(worlds.size());
  const auto take = [&results](std::size_t place, WorldResult result) { results[place] = std::move(result); };
  if (!run(worlds, take)) return {};
  std::string encoded;
  for (const WorldResult& result : results) encode(result, encoded);
  return encoded;
}

}  // namespace momentree::sweep
