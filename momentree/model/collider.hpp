#pragma once
// What bodies can touch with, and the laws of their contacts.
#include <memory>
#include <string>
#include <vector>

#include <momentree/contact/shapes/solid.hpp>
#include <momentree/model/ids.hpp>

namespace momentree {

namespace contact {
struct HeightField;
}

/// Handle of a collider: its place in the order in which the colliders of the model were added.
struct ColliderId {
  int index = -1;
  friend bool operator==(ColliderId, ColliderId) = default;
};

/// Friction and restitution of a contact.
struct ContactLaw {
  double friction = 0.5;         ///< coefficient while it slips
  double static_friction = 0.5;  ///< coefficient up to which it sticks; at least that of slip
  double torsional = 0;          ///< the largest moment about the normal, divided by the normal force (m)
  double rolling = 0;            ///< the same about the tangents: rolling resistance (m)
  double restitution = 0;        ///< 0 (plastic) to 1
  bool off = false;              ///< the bodies pass through each other
  bool has_moments() const { return torsional > 0 || rolling > 0; }
  friend bool operator==(const ContactLaw&, const ContactLaw&) = default;
};

/// A solid of a body in its user frame, or of the ground in the world; or a plane or a height field of the ground.
struct Collider {
  BodyId body = ground;
  contact::Solid solid{};                               ///< of a plane or a field only its `belt` counts
  bool plane = false;                                   ///< a plane with the ground below it
  Vec3 point{}, normal{0, 0, 1};                        ///< of the plane: a point (m), and its normal
  std::shared_ptr<const contact::HeightField> field{};  ///< of contact::height_field(); null: none
  friend bool operator==(const Collider&, const Collider&) = default;
};

/// A law for contacts between bodies of two sets. Empty sets: all bodies and the ground.
struct ContactRule {
  std::string name{};  ///< of its impacts, if it has one
  std::vector<BodyId> one{}, other{};
  ContactLaw law{};
  /// All bodies with this name, or of the mechanism with this name, belong to the set, too, also those that are added later, even
  /// to a running world; `*` stands for any part of a name. Empty: only those in the set.
  std::string one_name{}, other_name{};
};

}  // namespace momentree
