#pragma once
// What a run says when it can't go on: it diverged, or it gets nowhere.
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// Which joint ran away in a step of h seconds, and what to do; the world is at its last good state.
std::string divergence_text(const World& world, const Integrator& method, const Integration& integration, double h);

/// "no progress at t = 0.25 s: "
std::string no_progress_at(double time);

/// The last two events, "'stop: hit m/a lower' and 'grasp: weld …'".
std::string last_events(std::span<const Event> events);

/// Finds out when a run gets nowhere: looks back over many steps at a time.
class ProgressMonitor {
 public:
  void begin(double time, std::size_t events) { steps_ = 0, time_ = time, events_ = events; }

  /// To be called after each step. Says why, where the run to `until` would not end in a time that anybody waits for.
  std::optional<std::string> step(const World& world, const Integrator& method, const Integration& integration,
                                  std::span<const Event> events, double until) {
    if (++steps_ < steps_between_looks) return std::nullopt;
    return look(world, method, integration, events, until);
  }

 private:
  static constexpr int steps_between_looks = 200'000;
  std::optional<std::string> look(const World& world, const Integrator& method, const Integration& integration,
                                  std::span<const Event> events, double until);

  int steps_ = 0;  // since the last look
  double time_ = 0;
  std::size_t events_ = 0;
};

}  // namespace momentree
