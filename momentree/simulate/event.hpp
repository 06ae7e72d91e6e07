#pragma once
// A row of the result: what happened, when, and what it conserved.
#include <array>
#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

#include <momentree/dynamics/totals.hpp>

namespace momentree {

struct Event {
  double time = 0;
  std::string name;                  ///< the event's name, or #1, #2 … by its place
  std::vector<std::string> actions;  ///< "break chain/41"; "break chain/41 skipped: …"
  std::vector<std::string> mechanisms_before, mechanisms_after;
  Totals before, after;
  double released = 0;  ///< energy of springs and rotors that left with a freedom (J)
  std::vector<std::pair<std::string, std::array<double, 6>>> impulse;  ///< per joint, child's axes; only where not zero
  std::array<double, 6> ground_impulse{};                              ///< world axes, about the world's origin
  double duration_ns = 0;  ///< the change itself, the evaluations before and after it apart
};

}  // namespace momentree
