#pragma once
// Messages of a run that cannot continue: it diverged or makes no progress.
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// Reports which joint diverged in a step of h seconds, and suggests remedies; the world is at its last good state.
std::string divergence_text(const World& world, const Integrator& method, const Integration& integration, double h);

/// "no progress at t = 0.25 s: "
std::string no_progress_at(double time);

/// The last two events: "'stop: hit m/a lower' and 'grasp: weld …'".
std::string last_events(std::span<const Event> events);

/// What can cause events.
struct EventSources {
  std::size_t sources = 0;  ///< bodies and planes that can touch, cables, joints with hard stops, and scheduled events
  double repeated = 0;      ///< the rate of those that repeat (1/s)
};

/// True if the last 10,000 events took less time than the run's `step` (s), or a millisecond if that is less: more than
/// `flood_text` permits may have happened.
bool may_be_flood(std::span<const Event> events, double now, double step);
/// A message if more than 10,000 events, and 100 for each source, happened in that time, and none of them began stepping through
/// contacts.
std::optional<std::string> flood_text(std::span<const Event> events, double now, double step, const EventSources& from);

/// Detects runs that make no progress, by their advance over many steps.
class ProgressMonitor {
 public:
  /// The last check, and the steps since then.
  struct Mark {
    int steps = 0;
    double time = 0;  ///< s
    std::size_t events = 0;
  };

  void begin(double time, std::size_t events) { mark_ = {0, time, events}; }
  const Mark& mark() const { return mark_; }
  void continue_from(const Mark& mark) { mark_ = mark; }

  /// Call after each step. Returns a message if the run to `until` would not end in a reasonable time.
  std::optional<std::string> step(const World& world, const Integrator& method, const Integration& integration,
                                  std::span<const Event> events, double until) {
    if (++mark_.steps < steps_between_looks) return std::nullopt;
    return look(world, method, integration, events, until);
  }

 private:
  static constexpr int steps_between_looks = 200'000;
  std::optional<std::string> look(const World& world, const Integrator& method, const Integration& integration,
                                  std::span<const Event> events, double until);

  Mark mark_;
};

}  // namespace momentree
