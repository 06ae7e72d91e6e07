#pragma once
// Everything that happens at one instant, in its order: 1. what changes no velocity (break, free, unlock, changes whose freedoms
// contain the old ones), 2. lock, weld, attach and all other changes, together one impact, 3. impulses, 4. parameters; within
// each in the order of the events and of their actions. All of it, or nothing.
#include <span>
#include <string>
#include <vector>

#include <momentree/simulate/action.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// An event that is due.
struct DueEvent {
  std::string name;
  bool named = false;  ///< by its user: a joint that it makes then has that name
  std::vector<Action> actions;
};

/// What one action became.
struct ActionReport {
  std::size_t event = 0, action = 0;  ///< places in the instant's events
  ActionResult result;
};

struct InstantReport {
  bool refused = false;               ///< nothing happened; the last of `actions` says why
  bool lost = false;                  ///< in a rehearsal: the state lost its meaning, so nothing can be tried after it
  std::string message;                ///< of a refusal: which action, why, and how to mend it
  std::vector<ActionReport> actions;  ///< in the order in which they were carried out
  std::vector<Event> events;          ///< one for each that was due, with certificates
  double seconds = 0;                 ///< spent in changes alone
  long changes = 0;
};

/// No more actions than this at one instant.
inline constexpr std::size_t most_actions_at_once = 10'000;

/// The name that a joint made by the `action`-th action of an event gets: the event's own where it makes one joint only, else
/// "<to>+<body>". Empty for actions that make none.
std::string made_joint_name(const DueEvent& event, std::size_t action);

/// `rehearsal`: see TopologyEditor.
InstantReport carry_out(World& world, std::span<const DueEvent> due, bool dry_run = false);

}  // namespace momentree
