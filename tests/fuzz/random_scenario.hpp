#pragma once
// Random scenarios, as text: worlds of one to ten bodies with many events.
#include <string>
#include <utility>
#include <vector>

#include <momentree/joint/joint.hpp>
#include <tests/fuzz/choices.hpp>

namespace momentree::fuzz {

/// The text of a scenario: usually a valid one; equal choices yield equal texts.
/// `mixed`: with contact, and maybe cables, loops, exact couplings and time stepping.
std::string random_scenario(Choices& choose, bool mixed);
/// Half of them are mixed.
inline std::string random_scenario(Choices& choose) {
  const bool mixed = choose.chance(0.5);
  return random_scenario(choose, mixed);
}

/// Stacks that stand or fall, with contact everywhere.
std::string random_pile(Choices& choose);

/// The parts written so far, for references to them.
struct Draft {
  struct DraftJoint {
    std::string name, child;  ///< complete names
    const KindInfo* kind;
    bool root = false;    ///< to the ground
    bool moves = false;   ///< prescribed
    bool strong = false;  ///< breaks by itself
    bool coupled = false;
    bool decided = false;  ///< an event breaks, changes or frees it
    bool locked = false;   ///< an event locks it
    bool made = false;     ///< by an event
  };
  struct DraftEvent {
    std::string name;
    bool waits = false;  ///< for a condition
  };
  Choices& choose;
  std::string text{};
  std::vector<DraftJoint> joints{};
  std::vector<std::string> bodies{}, mechanisms{};
  std::vector<std::string> solids{};  ///< bodies that touch others
  std::vector<bool> floats{};         ///< by mechanism
  std::vector<DraftEvent> events{};
  double until = 1;
  bool certain = false;  ///< no event depends on a condition: the effects of its events are known before the run
  bool mixed = false;    ///< has contact, and may have cables, loops and exact couplings
  bool heavy = false;    ///< has resistance that is too stiff for explicit methods
};

/// Keys with their values.
using Entries = std::vector<std::pair<std::string, std::string>>;
/// As lines, or in one line between braces.
std::string lines(const Entries& entries);
std::string braces(const Entries& entries);
bool has(const Entries& entries, const char* key);
inline std::string quoted(const std::string& text) { return '"' + text + '"'; }

/// Adds a mechanism of at most `most` bodies; returns the number of bodies.
int add_mechanism(Draft& draft, int most);
void add_couplings(Draft& draft);
void add_forces(Draft& draft);
void add_springs(Draft& draft);
void add_contacts(Draft& draft);
void add_cables(Draft& draft);
void add_loops(Draft& draft);
void add_event(Draft& draft);

/// Start values: coordinates of a joint kind; angles and lengths up to `size`.
std::string random_coordinates(Choices& choose, const KindInfo& kind, double size = 1);
std::string random_velocities(Choices& choose, const KindInfo& kind);
/// Some of the parameters of a joint.
Entries random_parameters(Draft& draft, const KindInfo& kind, bool may_move = true);
/// Axes and pitch of a joint.
Entries random_geometry(Choices& choose, const KindInfo& kind);
/// What a body touches others with.
std::string random_collision(Choices& choose);
/// Friction and restitution.
Entries random_contact_law(Choices& choose);
/// Two that may touch.
std::string touching_pair(Draft& draft);
/// A number, or a time-dependent signal.
std::string random_signal(Draft& draft, double size);

}  // namespace momentree::fuzz
