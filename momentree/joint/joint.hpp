#pragma once
// What a joint is for its user: a kind, its geometry and its parameters. The kinds themselves are in kinds/, one file each.
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/math/values.hpp>
#include <momentree/math/vec.hpp>

#include <momentree/joint/kind_list.hpp>  // generated from the files in kinds/: MOMENTREE_KINDS(X), X(lower_case, TypeName)

namespace momentree {

/// The kinds of joint, in alphabetical order of their files.
enum class Kind : unsigned char {
#define MOMENTREE_KIND(name, Type) name,
  MOMENTREE_KINDS(MOMENTREE_KIND)
#undef MOMENTREE_KIND
};

/// What is known of a kind at run time, for readers and writers of files.
struct KindInfo {
  Kind kind;
  const char* name;         ///< as in scenario files: "revolute"
  int nq, nv;               ///< coordinates and freedoms
  bool axis, axis2, pitch;  ///< which geometry it takes
  const char* q_units;      ///< one letter per coordinate: r = rad, m = metre, n = number (quaternion component)
  const char* v_units;      ///< one letter per freedom: r = rad/s (N m for its momentum's force), m = m/s (N)
};
const KindInfo& info(Kind kind);
/// Every kind, in order of the enum.
const std::vector<KindInfo>& all_kinds();
/// The kind of that name, or null.
const KindInfo* find_kind(std::string_view name);

/// Hard stops of a joint: coordinates that its freedoms do not pass. One number applies to every freedom, a list has one per
/// freedom in the order of v; infinite or absent: no stop. Only for kinds whose velocities are the rates of their coordinates.
struct JointLimits {
  Values lower{}, upper{};   ///< rad, m
  Values restitution{};      ///< 0 (plastic, also where absent) … 1: what is left of the speed, turned about
  double rest_speed = 1e-3;  ///< below it (rad/s, m/s) the joint comes to rest on the stop, until something pulls it off
  bool any() const { return !lower.empty() || !upper.empty(); }
  double lower_of(int freedom) const { return of(lower, freedom, -std::numeric_limits<double>::infinity()); }
  double upper_of(int freedom) const { return of(upper, freedom, std::numeric_limits<double>::infinity()); }
  double restitution_of(int freedom) const { return of(restitution, freedom, 0); }
  friend bool operator==(const JointLimits&, const JointLimits&) = default;

 private:
  static double of(const Values& values, int i, double none) {
    return values.size() == 1 ? values[0] : i < values.size() ? values[i] : none;
  }
};

/// Parameters of a joint. One number applies to every freedom, a list has one per freedom in the order of v
/// (`effort` as a single number only for kinds with one freedom). SI units. They belong to the joint, not to the child body.
struct JointParameters {
  Values damping{};    ///< torque or force −damping·v
  Values stiffness{};  ///< spring about `rest`
  Values rest{};       ///< coordinates (order of q) at which the spring is at rest; empty: the joint's zero
  Values armature{};   ///< rotor inertia reflected to the joint, added to the joint-space mass
  Values effort{};     ///< constant driving force or torque
  JointLimits limits{};
  friend bool operator==(const JointParameters&, const JointParameters&) = default;
};

/// A joint of any kind.
struct JointSpec {
  Kind kind = Kind::weld;
  Vec3 axis{0, 0, 1};  ///< in the joint's frame; normalised by the model
  Vec3 axis2{};        ///< universal: the second axis, turned by the first rotation
  double pitch = 0;    ///< helical: displacement per turn (m)
  JointParameters parameters;

  JointSpec() = default;
  /// From a kind's own struct: `Revolute{.axis = {0, 0, 1}, .damping = 1e-5}`.
  template <class K>
  requires requires { K::kind; }
  JointSpec(const K& k) : kind(K::kind) {  // NOLINT(google-explicit-constructor): .joint = Revolute{…}
    if constexpr (requires { k.axis; }) axis = k.axis;
    if constexpr (requires { k.axis2; }) axis2 = k.axis2;
    if constexpr (requires { k.pitch; }) pitch = k.pitch;
    if constexpr (requires { k.damping; }) parameters = {k.damping, k.stiffness, k.rest, k.armature, k.effort, {}};
    if constexpr (requires { k.limits; }) parameters.limits = k.limits;
  }
};

/// Unit vectors, to write `.axis = z`.
inline constexpr Vec3 x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1};

}  // namespace momentree
