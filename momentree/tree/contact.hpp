#pragma once
// Contacts that are closed at present: pairs of features that press on each other. They open and close at located instants.
#include <cstdint>

#include <momentree/contact/shapes/feature.hpp>

namespace momentree {

/// A closed contact between two bodies, or a body and the ground. The normal acceleration of its features is zero.
struct Contact {
  /// How its features move along each other.
  enum class Mode : unsigned char {
    smooth,  ///< without friction
    stick,   ///< they do not
    slip     ///< against the friction of a sliding contact
  };
  contact::Features features;  ///< in the bodies' user frames; of the ground, in the world
  int a = -1, b = -1;          ///< bodies; −1: the ground
  Vec3 belt_a{}, belt_b{};     ///< of their solids: see contact::Solid
  Mode mode = Mode::smooth;
  double friction = 0;  ///< coefficient: kinetic, or static of one that sticks
  Vec3 direction{};     ///< of slip where the velocity is zero: a unit vector, world axes
  /// The direction of friction is that of the slip and this speed (m/s) along `direction` together: friction of slow slip turns
  /// more quickly than a step can follow. Of a contact that sticks, with all that it touches, at the limit of its friction:
  /// positive, without a direction.
  double keeps_direction = 0;
  int pair = -1;         ///< number of the pair of solids
  std::uint64_t id = 0;  ///< of its features in that pair
  double settles = -1;   ///< when the bounces end that were too low to be followed (s); −1: there are none
  int cable = -1;        ///< the spring of the model that is taut; −1: bodies touch
  bool pending = false;  ///< found before the run begins, which closes it with an event

  friend bool same_contact(const Contact& x, const Contact& y) { return x.pair == y.pair && x.id == y.id; }
};

}  // namespace momentree
