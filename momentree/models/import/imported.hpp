#pragma once
// The result of an importer, whatever the format: bodies in tree order, with their places in the file for messages.
#include <array>
#include <compare>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/model/model.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/models/xml/file.hpp>

namespace momentree::io {

/// Places of the parts of a body; a part without its own element has the body's place.
struct BodySpots {
  XmlFile* file = nullptr;
  XmlElement body{}, joint{}, inertia{}, limits{};
};

/// Which solids touch, by bits: two do if the `own` bits of one and the `others` of the other have a bit in common.
struct CollisionMask {
  std::uint32_t own = 1, others = 1;
  friend auto operator<=>(const CollisionMask&, const CollisionMask&) = default;
};
inline bool touch_by_masks(const CollisionMask& a, const CollisionMask& b) {
  return (a.own & b.others) != 0 || (b.own & a.others) != 0;
}

/// What a body, or the ground, touches with.
struct ImportedSolids {
  std::vector<Shape> collision{};      ///< of a body in its frame, of the ground in that of the file
  std::vector<CollisionMask> masks{};  ///< by collision; without them all touch
  double friction = -1;                ///< coefficient of its contacts; negative: the file gives none
};

struct ImportedBody : ImportedSolids {
  BodySpec spec;          ///< names without a mechanism; the parent is an index among the bodies of this model, or the ground
  bool own_joint = true;  ///< false for a root without a joint in the file: `root` determines how it is attached
  bool floats = false;    ///< such a root is free, not fixed, unless `root` is given
  JointLimits limits{};   ///< as in the file; used if the mechanism requests it
  std::vector<Shape> shapes{};
  BodySpots spots{};
};

/// A joint that closes a loop, in addition to the joints of the tree.
struct ImportedLoop {
  LoopSpec spec;         ///< the name without a mechanism; bodies are indices among those of this model
  JointLimits limits{};  ///< as in the file; used if the mechanism requests it
  BodySpots spots{};     ///< the body's are the joint's
};

/// A joint that follows another according to the file: q = multiplier·q(leader) + offset + higher powers. Without a leader it is
/// held at the offset.
struct Follower {
  int body = -1, leader = -1;  ///< joints, identified by the bodies that they carry; −1: none
  double multiplier = 1, offset = 0;
  XmlFile* file = nullptr;
  XmlElement element{};
  std::array<double, 3> higher{};  ///< coefficients of q², q³ and q⁴
  bool exact = false;              ///< it is coupled exactly, unless the mechanism says otherwise

  /// The coupling of joints whose numbers begin at `first`.
  Coupling coupling(int first) const { return {{first + body}, {leader < 0 ? -1 : first + leader}, multiplier, offset, higher}; }
  /// A spring can take its place.
  bool linear() const { return leader >= 0 && multiplier != 0 && higher == std::array<double, 3>{}; }
};

/// A spring between points of bodies of this model, or of the ground in the frame of the file. Its name is without a mechanism.
struct ImportedSpring {
  Spring spring;
  XmlFile* file = nullptr;
  XmlElement element{};
};

/// Files give dry friction without the speed over which it builds up (rad/s or m/s); this speed is used.
inline constexpr double imported_friction_speed = 1e-2;

/// The warning of files with a second coefficient of contact friction, and its hint.
inline constexpr const char* different_friction =
    "different friction along two tangents is not represented: the first coefficient counts";
inline constexpr const char* friction_hint = "[[contact]] gives pairs their friction";
inline constexpr const char* moments_hint =
    "friction = { kinetic, torsional, rolling } of [[contact]] has them, by time stepping";

/// Of two bodies with coefficients of their own, the file's format takes this one.
enum class FrictionOfTwo { larger, smaller };

/// Two bodies that touch whatever their masks are; an index of −1: the ground.
struct ImportedPair {
  int one = -1, other = -1;
  double friction = 0;
};

struct ImportedModel {
  std::string title;  ///< the model's name in the file
  /// parents before their children; a deque, since the elements are large and should not be moved
  std::deque<ImportedBody> bodies;
  std::vector<ImportedLoop> loops;
  std::vector<Follower> followers;
  std::vector<ImportedSpring> springs;
  std::optional<Vec3> gravity;  ///< if the file has one (m/s²)
  FrictionOfTwo friction_of_two = FrictionOfTwo::smaller;
  std::vector<std::pair<std::string, std::string>> excluded;  ///< bodies that pass through each other
  ImportedSolids ground;                                      ///< what is in the world without being part of a body
  std::vector<ImportedPair> pairs;                            ///< not `excluded`
};

}  // namespace momentree::io
