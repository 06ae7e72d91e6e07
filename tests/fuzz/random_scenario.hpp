#pragma once
// Random scenarios, as text: worlds of one to ten bodies in which much happens.
#include <string>
#include <utility>
#include <vector>

#include <momentree/joint/joint.hpp>
#include <tests/fuzz/choices.hpp>

namespace momentree::fuzz {

/// The text of a scenario: mostly a valid one, the same for the same choices.
std::string random_scenario(Choices& choose);

/// What has been written so far, for what refers to it.
struct Draft {
  struct DraftJoint {
    std::string name, child;  ///< complete names
    const KindInfo* kind;
    bool root = false;    ///< to the ground
    bool moves = false;   ///< prescribed
    bool strong = false;  ///< breaks by itself
    bool coupled = false;
    bool decided = false;  ///< an event breaks it, changes it, sets it free
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
  std::vector<bool> floats{};  ///< by mechanism
  std::vector<DraftEvent> events{};
  double until = 1;
  bool certain = false;  ///< no event waits for a condition: what its events will do is known before it runs
  bool heavy = false;    ///< resistance that only a method for it can step over
};

/// Keys with their values.
using Entries = std::vector<std::pair<std::string, std::string>>;
/// As lines, or in one line between braces.
std::string lines(const Entries& entries);
std::string braces(const Entries& entries);
bool has(const Entries& entries, const char* key);
inline std::string quoted(const std::string& text) { return '"' + text + '"'; }

/// A mechanism of at most so many bodies; returns how many.
int add_mechanism(Draft& draft, int most);
void add_couplings(Draft& draft);
void add_forces(Draft& draft);
void add_event(Draft& draft);

/// Start values: the coordinates of a kind, angles and lengths at most of this size.
std::string random_coordinates(Choices& choose, const KindInfo& kind, double size = 1);
std::string random_velocities(Choices& choose, const KindInfo& kind);
/// Some of the parameters of a joint.
Entries random_parameters(Draft& draft, const KindInfo& kind, bool may_move = true);
/// A number, or what changes with time.
std::string random_signal(Draft& draft, double size);

}  // namespace momentree::fuzz
