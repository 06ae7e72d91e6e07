#pragma once
// Handles of bodies and joints.

namespace momentree {

/// Handle of a body. Never changes, whatever the body is joined to.
struct BodyId {
  int index = -1;
  friend bool operator==(BodyId, BodyId) = default;
};
/// The ground, as a parent.
inline constexpr BodyId ground{-1};

/// Handle of a joint: it stays with the joint for as long as that exists, also where re-rooting makes another body carry it. In a
/// model the inboard joint of a body has the body's number. Loop joints have numbers from first_loop on; one that takes the place
/// of a broken joint in the tree then has that joint's number.
struct JointId {
  int index = -1;
  friend bool operator==(JointId, JointId) = default;
};

inline constexpr int first_loop = 1 << 28;
/// True for a joint that closes a loop.
inline constexpr bool is_loop(JointId joint) { return joint.index >= first_loop; }

}  // namespace momentree
