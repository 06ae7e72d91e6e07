#pragma once
// The angles of a joint, which its pose alone gives only up to full turns.

namespace momentree {

/// The angles of a joint's axes (rad), in the order of its coordinates: two of a universal joint, at most one of the other kinds.
/// As a hint: new angles are those nearest to these.
struct Turns {
  double first = 0, second = 0;
  friend bool operator==(const Turns&, const Turns&) = default;
};

}  // namespace momentree
