#pragma once
// Parts of a running simulation that have a subject of their own: its activity, callbacks, energy, history and outcome.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/base/periodic.hpp>
#include <momentree/base/restored.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

/// What a simulation is doing at present, which determines what a callback may do: see Simulation.
struct Activity {
  enum class Doing { nothing, observing, watching, working };
  using During = detail::Restored<Doing>;

  explicit Activity(const Workspace<double>& workspace) : workspace_(&workspace) {}
  Doing doing = Doing::nothing;
  bool idle() const { return doing == Doing::nothing && !workspace_->in_function; }
  bool steady() const { return doing != Doing::working && !workspace_->in_function; }

 private:
  const Workspace<double>* workspace_;
};

/// The callbacks of a run, and when the observer is due.
struct Observers {
  double every = 0, next_look = 0, observed_at = 0;
  bool observed = false;
  std::function<bool(const World&)> observer;
  std::function<bool(const World&)> sampler;
  std::function<bool(double)> watcher;

  /// The observer's next instant is the first one from now on.
  void look_anew(double now) {
    observed = false;
    if (every > 0) next_look = Periodic(0, every).first_from(now);
  }
  /// Whether the observer is to be called now; `force`: at the end of a run.
  bool is_due(double now, bool force) const {
    return observer && !(observed && observed_at == now) && (force || every <= 0 || now >= next_look);
  }
  void note_look(double now) {
    observed = true;
    observed_at = now;
    if (every > 0) next_look = Periodic(0, every).first_after(now);
  }
};

inline double total_energy(const World& world) {
  const Totals t = world.totals();
  return t.kinetic + t.potential;
}

/// The energy of a run (J): where it came from and went.
struct EnergyBook {
  EnergyBalance balance;
  EnergyLedger ledger;
  std::optional<double> unadjusted;  ///< total energy before adjustments that are not in the balance yet

  void begin(const World& world) {
    const Totals t = world.totals();
    balance.initial = t.kinetic + t.potential;
    balance.largest_kinetic = t.kinetic;
  }
  /// Books the work of adjustments, which are evaluated only when the balance is needed.
  void settle(const World& world) {
    if (!unadjusted) return;
    balance.work += total_energy(world) - *std::exchange(unadjusted, std::nullopt);
  }
  void add(const Event& event) {
    balance.largest_kinetic = std::max({balance.largest_kinetic, event.before.kinetic, event.after.kinetic});
    balance.released += event.released;
    balance.lost_in_impacts += event.lost;
    balance.work += event.work;
  }
};

/// Snapshots from before the instants at which something happened.
struct RunHistory {
  struct Past {
    std::size_t events;  ///< number of events that had happened before
    SimulationSnapshot before;
    std::vector<std::size_t> places;  ///< places in the queue of the events that were due
  };
  std::size_t most = 0;  ///< instants that are kept: the last ones
  std::vector<Past> instants;

  bool keeps() const { return most > 0; }
  void keep(Past past) {
    if (instants.size() >= most) instants.erase(instants.begin(), instants.end() - static_cast<std::ptrdiff_t>(most - 1));
    instants.push_back(std::move(past));
  }

  /// The snapshot from before the instant of that event, of so many; null: none was kept.
  const Past* before(std::size_t event, std::size_t events) const {
    for (const Past& past : instants) {
      const bool last = &past == &instants.back();
      if (event >= past.events && event < (last ? events : (&past + 1)->events)) return &past;
    }
    return nullptr;
  }
};

/// How the last call ended, and what prevents the next one.
struct Outcome {
  std::string message;                    ///< the reason, as soon as it is known
  RunResult result;                       ///< of the last call that returned one
  std::optional<std::string> overlapped;  ///< which bodies, when an overlap was reported last
  bool diverged = false, stalled = false;

  void stall(std::string why) { message = std::move(why), stalled = true; }
};

/// Code that was generated for the topology, and what it was last asked for.
struct GeneratedStages {
  RatesProvider provider;
  std::optional<std::uint64_t> asked_for;  ///< the revision of the tree
  std::vector<int> rows;                   ///< and the chosen rows of its loops
};

}  // namespace momentree
