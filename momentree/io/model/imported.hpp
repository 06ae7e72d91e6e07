#pragma once
// What an importer makes of a model file, whatever its format: bodies in the order of their trees, with the places that messages
// about them need.
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/io/shape.hpp>
#include <momentree/io/xml/file.hpp>
#include <momentree/tree/model.hpp>

namespace momentree::io {

/// Where the parts of a body stand; what a format has no place for is the body's.
struct BodySpots {
  XmlFile* file = nullptr;
  XmlElement body{}, joint{}, inertia{}, limits{};
};

struct ImportedBody {
  BodySpec spec;          ///< names without a mechanism; the parent is a number among the bodies of this model, or the ground
  bool own_joint = true;  ///< false for a root that the file joins to nothing: `root` says how it is held
  bool floats = false;    ///< such a root is free where `root` is not said, not fixed
  JointLimits limits{};   ///< as the file has them; they are taken up where the mechanism says so
  std::vector<Shape> shapes{};
  BodySpots spots{};
};

/// A joint that the file has follow another: q = multiplier·q(leader) + offset.
struct Follower {
  int body = -1, leader = -1;  ///< joints, by the bodies that they carry
  double multiplier = 1, offset = 0;
  XmlFile* file = nullptr;
  XmlElement element{};
};

/// Files give dry friction without the speed over which it builds up: rad/s or m/s.
inline constexpr double imported_friction_speed = 1e-2;

struct ImportedModel {
  std::string title;                ///< what the file calls itself
  std::deque<ImportedBody> bodies;  ///< parents before their children; large ones, that no growth should copy
  std::vector<Follower> followers;
  std::optional<Vec3> gravity;  ///< where the file has one
};

}  // namespace momentree::io
