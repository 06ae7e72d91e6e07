#pragma once
// What a joint is for its user: a kind, its geometry and its parameters. The kinds themselves are in kinds/, one file each.
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/math/signal.hpp>
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

/// Stops of a joint: coordinates that its freedoms do not pass, or, soft ones, that they are pushed back from. One number applies
/// to every freedom, a list has one per freedom in the order of v; infinite or absent: no stop. Only for kinds whose velocities
/// are the rates of their coordinates.
struct JointLimits {
  Values lower{}, upper{};   ///< rad, m
  Values restitution{};      ///< 0 (plastic, also where absent) … 1: what is left of the speed, turned about
  double rest_speed = 1e-3;  ///< below it (rad/s, m/s) the joint comes to rest on the stop, until something pulls it off
  /// Soft stops instead, where a stiffness is given: passed by x at the speed u, a stop pushes back with stiffness·x + damping·u
  /// (N m/rad, N m s/rad; N/m, N s/m), and never pulls. No restitution then.
  Values stiffness{}, damping{};
  bool any() const { return !lower.empty() || !upper.empty(); }
  bool soft() const { return any() && !stiffness.empty(); }
  bool hard() const { return any() && stiffness.empty(); }
  double lower_of(int dof) const { return lower.of(dof, -std::numeric_limits<double>::infinity()); }
  double upper_of(int dof) const { return upper.of(dof, std::numeric_limits<double>::infinity()); }
  double restitution_of(int dof) const { return restitution.of(dof); }
  friend bool operator==(const JointLimits&, const JointLimits&) = default;
};

/// Dry friction, smoothed so that it has a derivative: torque or force −coulomb·tanh(u / speed).
struct JointFriction {
  Values coulomb{};  ///< N m, N
  Values speed{};    ///< rad/s, m/s: three times it is sliding with 99.5 % of `coulomb`
  bool any() const { return coulomb.any(); }
  bool given() const { return !coulomb.empty() || !speed.empty(); }
  friend bool operator==(const JointFriction&, const JointFriction&) = default;
};

/// What drives a joint, beside its constant effort: in lists of signals one entry per freedom in the order of v. Either efforts,
/// with or without position control, or a motion.
struct JointDrive {
  /// Torque or force that changes with time; any kind. One entry alone only for joints with one freedom.
  std::vector<Signal> effort{};
  /// Position control: kp·(target − q) + kd·(target_speed − u), no more than max_effort either way. Only for kinds whose
  /// velocities are the rates of their coordinates. One entry alone applies to every freedom.
  struct Pd {
    Values kp{}, kd{};
    std::vector<Signal> target{};        ///< empty: the joint's zero
    std::vector<Signal> target_speed{};  ///< empty: the rate of the target
    Values max_effort{};                 ///< empty: unbounded
    bool any() const { return !kp.empty() || !kd.empty(); }
    friend bool operator==(const Pd&, const Pd&) = default;
  } pd{};
  /// Prescribed motion of a joint with one freedom (one entry): its position at every instant. It has no momentum of its own
  /// then, and takes the effort that it needs.
  std::vector<Curve> motion{};
  bool moves() const { return !motion.empty(); }
  friend bool operator==(const JointDrive&, const JointDrive&) = default;
};

/// Drives by themselves: `.drive = motion_drive(Signal::sine(0.5, 2))`.
std::shared_ptr<const JointDrive> effort_drive(std::vector<Signal> effort);
std::shared_ptr<const JointDrive> pd_drive(JointDrive::Pd pd);
std::shared_ptr<const JointDrive> motion_drive(const Signal& position);

/// Gives a motion that begins where its joint stands (Signal::ramp_from_here) its offset, for a joint at `position` at time t.
void begin_motion(std::shared_ptr<const JointDrive>& drive, double position, double t);

/// What a joint bears: it breaks by itself at that reaction (norms at the joint, N and N m); infinite: any.
struct JointStrength {
  double force = std::numeric_limits<double>::infinity(), torque = std::numeric_limits<double>::infinity();
  bool any() const { return force < std::numeric_limits<double>::infinity() || torque < std::numeric_limits<double>::infinity(); }
  friend bool operator==(const JointStrength&, const JointStrength&) = default;
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
  JointFriction friction{};
  JointStrength strength{};
  std::shared_ptr<const JointDrive> drive{};  ///< null: none but `effort`; shared, so that copies do not allocate
  bool any() const;                           ///< false where all of it is nothing
  friend bool operator==(const JointParameters& a, const JointParameters& b) {
    const bool same_drive = a.drive == b.drive || (a.drive && b.drive && *a.drive == *b.drive);
    return same_drive && a.damping == b.damping && a.stiffness == b.stiffness && a.rest == b.rest && a.armature == b.armature &&
           a.effort == b.effort && a.limits == b.limits && a.friction == b.friction && a.strength == b.strength;
  }
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
    if constexpr (requires { k.damping; }) parameters = {k.damping, k.stiffness, k.rest, k.armature, k.effort, {}, {}, {}, {}};
    if constexpr (requires { k.limits; }) parameters.limits = k.limits;
    if constexpr (requires { k.drive; }) parameters.friction = k.friction, parameters.drive = k.drive;
    if constexpr (requires { k.strength; }) parameters.strength = k.strength;
  }
};

/// Unit vectors, to write `.axis = z`.
inline constexpr Vec3 x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1};

}  // namespace momentree
