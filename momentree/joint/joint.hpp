#pragma once
// User-level description of a joint: its kind, geometry and parameters. The kinds themselves are in kinds/, one file each.
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

/// Properties of a kind at run time, for readers and writers of files.
struct KindInfo {
  Kind kind;
  const char* name;         ///< the kind's name in scenario files: "revolute"
  int nq, nv;               ///< numbers of coordinates and of DoFs
  bool axis, axis2, pitch;  ///< the geometry parameters that the kind takes
  const char* q_units;      ///< one letter per coordinate: r = rad, m = metre, n = number (quaternion component)
  const char* v_units;      ///< one letter per DoF: r = rad/s (its generalised force in N m), m = m/s (N)
};
/// The properties of a kind, which must be one of the enumerators.
const KindInfo& info(Kind kind);
/// All kinds, in the order of the enum.
const std::vector<KindInfo>& all_kinds();
/// The kind of that name; null if there is none.
const KindInfo* find_kind(std::string_view name);

/// Stops of a joint: limits of its coordinates that are either hard, or soft (a spring and damper push the joint back). A single
/// number applies to every DoF, a list has one entry per DoF in the order of v; infinite or absent: no stop. Only for kinds whose
/// velocities are the rates of their coordinates.
struct JointLimits {
  Values lower{}, upper{};   ///< rad, m
  Values restitution{};      ///< fraction of the approach speed after the rebound: 0 (plastic, the default) … 1
  double rest_speed = 1e-3;  ///< below this speed (rad/s, m/s) the joint comes to rest on the stop, until a force pulls it off
  /// Soft stops, if a stiffness is given: at penetration x and speed u a stop pushes back with stiffness·x + damping·u (N m/rad,
  /// N m s/rad; N/m, N s/m) and never pulls. Soft stops have no restitution.
  Values stiffness{}, damping{};
  bool any() const { return !lower.empty() || !upper.empty(); }
  bool soft() const { return any() && !stiffness.empty(); }
  bool hard() const { return any() && stiffness.empty(); }
  double lower_of(int dof) const { return lower.of(dof, -std::numeric_limits<double>::infinity()); }
  double upper_of(int dof) const { return upper.of(dof, std::numeric_limits<double>::infinity()); }
  double restitution_of(int dof) const { return restitution.of(dof); }
  friend bool operator==(const JointLimits&, const JointLimits&) = default;
};

/// Dry friction, smoothed so that it is differentiable: torque or force −coulomb·tanh(u / speed).
struct JointFriction {
  Values coulomb{};  ///< N m, N
  Values speed{};    ///< rad/s, m/s: at three times this speed friction has reached 99.5 % of `coulomb`
  bool any() const { return coulomb.any(); }
  bool given() const { return !coulomb.empty() || !speed.empty(); }
  friend bool operator==(const JointFriction&, const JointFriction&) = default;
};

/// Drives of a joint, in addition to its constant effort: either efforts, with or without position control, or a prescribed
/// motion. Lists of signals have one entry per DoF in the order of v.
struct JointDrive {
  /// Torque or force as a function of time (N m, N); any kind. A single entry is allowed only for joints with one DoF.
  std::vector<Signal> effort{};
  /// Position control: kp·(target − q) + kd·(target_speed − u), limited to ±max_effort. Only for kinds whose velocities are the
  /// rates of their coordinates. A single entry applies to every DoF.
  struct Pd {
    Values kp{}, kd{};
    std::vector<Signal> target{};        ///< rad, m; empty: the joint's zero
    std::vector<Signal> target_speed{};  ///< rad/s, m/s; empty: the rate of the target
    Values max_effort{};                 ///< N m, N; empty: unbounded
    bool any() const { return !kp.empty() || !kd.empty(); }
    friend bool operator==(const Pd&, const Pd&) = default;
  } pd{};
  /// Prescribed motion of a joint with one DoF (one entry): its position (rad, m) as a function of time. The DoF then has no
  /// momentum of its own, and the drive supplies whatever effort the motion needs.
  std::vector<Curve> motion{};
  bool moves() const { return !motion.empty(); }
  friend bool operator==(const JointDrive&, const JointDrive&) = default;
};

/// Drives with a single element: `.drive = motion_drive(Signal::sine(0.5, 2))`.
std::shared_ptr<const JointDrive> effort_drive(std::vector<Signal> effort);
std::shared_ptr<const JointDrive> pd_drive(JointDrive::Pd pd);
std::shared_ptr<const JointDrive> motion_drive(const Signal& position);

/// Sets the offset of a prescribed motion that starts at the current position (Signal::ramp_from_here), for a joint at `position`
/// (rad, m) at time t (s). Other drives are unchanged.
void begin_motion(std::shared_ptr<const JointDrive>& drive, double position, double t);

/// Strength of a joint: it breaks when the norm of its reaction force (N) or torque (N m), taken at the joint, reaches the limit;
/// infinite: never.
struct JointStrength {
  double force = std::numeric_limits<double>::infinity(), torque = std::numeric_limits<double>::infinity();
  bool any() const { return force < std::numeric_limits<double>::infinity() || torque < std::numeric_limits<double>::infinity(); }
  friend bool operator==(const JointStrength&, const JointStrength&) = default;
};

/// Parameters of a joint, in SI units. They belong to the joint, not to the child body. A single number applies to every DoF, a
/// list has one entry per DoF in the order of v (`effort` may be a single number only for kinds with one DoF).
struct JointParameters {
  Values damping{};    ///< torque or force −damping·v (N m s/rad, N s/m)
  Values stiffness{};  ///< spring about `rest` (N m/rad, N/m)
  Values rest{};       ///< coordinates (in the order of q) at which the spring is relaxed; empty: the joint's zero
  Values armature{};   ///< rotor inertia reflected to the joint (kg m², kg), added to the joint-space mass
  Values effort{};     ///< constant driving force or torque (N m, N)
  JointLimits limits{};
  JointFriction friction{};
  JointStrength strength{};
  std::shared_ptr<const JointDrive> drive{};  ///< null: no drive other than `effort`; shared, so that copies do not allocate
  bool any() const;                           ///< false if no parameter has an effect
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
  Vec3 axis2{};        ///< universal: the second axis, carried along by the first rotation
  double pitch = 0;    ///< helical: displacement per revolution (m)
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
