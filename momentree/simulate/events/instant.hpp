#pragma once
// Carries out all actions of one instant in this order: 1. actions that change no velocity (break, free, unlock, changes that
// keep all DoFs of the old joint), 2. lock, weld, attach and all other changes, together as one impact, 3. impulses, 4.
// parameters. Within each group the order is that of the events and of their actions. Either all of them take effect or none.
#include <span>
#include <string>
#include <vector>

#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// An event that is due.
struct DueEvent {
  std::string name;
  bool named = false;  ///< named by the user: a joint that it makes then has that name
  std::vector<Action> actions;
};

/// Outcome of one action.
struct ActionReport {
  std::size_t event = 0, action = 0;  ///< places in the instant's events
  ActionResult result;
};

struct InstantReport {
  bool refused = false;               ///< nothing happened; the last of `actions` says why
  bool lost = false;                  ///< in a dry run: the state is no longer meaningful, so that nothing can be tried after it
  std::string message;                ///< for a refusal: which action, why, and how to correct it
  std::vector<ActionReport> actions;  ///< in the order in which they were carried out
  std::vector<Event> events;          ///< one for each event that was due, with its certificate
  double seconds = 0;                 ///< time spent in the changes alone
  long changes = 0;
};

/// Maximum number of actions at one instant.
inline constexpr std::size_t most_actions_at_once = 10'000;

/// Name of the joint that the `action`-th action of an event makes: the event's own name if the event makes only one joint,
/// otherwise "<to>+<body>". Empty for actions that make no joint.
std::string made_joint_name(const DueEvent& event, std::size_t action);

/// True if one of the actions of an event makes a joint of that name.
bool makes_joint(const DueEvent& event, const std::string& joint);

/// Says that an action of an event is refused, and why.
std::string refusal(const DueEvent& event, const Action& action, double time, const ActionResult& result);

/// `dry_run`: see TopologyEditor.
InstantReport carry_out(World& world, std::span<const DueEvent> due, bool dry_run = false);

/// True if some body lacks the mass or inertia to move freely alone, such as a point mass or a rod. Only such bodies can make a
/// joint singular.
[[nodiscard]] bool has_thin_bodies(const Model& model);

}  // namespace momentree
