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
/// model the inboard joint of a body has the body's number.
struct JointId {
  int index = -1;
  friend bool operator==(JointId, JointId) = default;
};

}  // namespace momentree
