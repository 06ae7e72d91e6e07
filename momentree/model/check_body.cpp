// Checks of one body and its joint.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <momentree/base/characters.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

namespace {

bool finite(double a) { return std::isfinite(a); }
bool finite(const Vec3& a) { return finite(a.x) && finite(a.y) && finite(a.z); }
bool finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](double a) { return finite(a); });
}

// An axis may have any length, but a nearly zero vector has no intended direction.
bool too_short(const Vec3& axis) { return std::max({std::fabs(axis.x), std::fabs(axis.y), std::fabs(axis.z)}) < 1e-9; }

bool parallel(const Vec3& a, const Vec3& b) {
  const auto unit = [](const Vec3& v) {
    return normalized((1 / std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)})) * v);
  };
  return norm(cross(unit(a), unit(b))) < 1e-6;
}

std::string counted(int n, const char* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); }

struct QuaternionCheck {
  const char *what, *hint;
};
QuaternionCheck check_quaternion(double w, double x, double y, double z) {
  const double length = std::hypot(std::hypot(w, x), std::hypot(y, z));
  if (length == 0) return {"a quaternion of zeros is not a rotation", "the identity is [1, 0, 0, 0]"};
  if (!(std::fabs(length - 1) <= 1e-6)) return {"the length of the quaternion is not 1", "scale it: w² + x² + y² + z² = 1"};
  return {};
}

// The quaternion among the coordinates, if the kind has one and the number of coordinates is right.
QuaternionCheck check_quaternion(const Values& q, const KindInfo& kind) {
  for (int i = 0; i + 3 < q.size(); ++i)
    if (kind.q_units[i] == 'n') return check_quaternion(q[i], q[i + 1], q[i + 2], q[i + 3]);
  return {};
}

template <class Problem>
class Checks {
 public:
  void add(const char* field, std::string what, std::string hint = {}) {
    problems.push_back({field, std::move(what), std::move(hint)});
  }
  // Names must not need quoting in CSV columns, targets of events or terminals.
  void name(const char* field, const std::string& name) {
    if (name.size() > 500) add(field, "is longer than 500 characters");
    if (name.find_first_of(",\"*") != std::string::npos) add(field, "must not contain a comma, a quotation mark or an asterisk");
    if (first_invisible(name) != std::string::npos)
      add(field, "must be UTF-8 without control characters and other invisible characters");
  }
  void coordinates(const char* field, const Values& q, const KindInfo& kind) {
    if (q.empty()) return;
    if (!finite(q)) return add(field, "must be finite");
    if (q.size() != kind.nq)
      return add(field, "a " + std::string(kind.name) + " joint has " + counted(kind.nq, "coordinate") + ", not " +
                            std::to_string(q.size()));
    if (const QuaternionCheck bad = check_quaternion(q, kind); bad.what) add(field, bad.what, bad.hint);
  }
  void axis(const char* field, const Vec3& axis) {
    if (!finite(axis)) return add(field, "must be finite");
    if (too_short(axis)) add(field, "an axis of length zero has no direction", "for example [0, 0, 1]");
  }
  void placement(const char* field, const Pose& pose) {
    const Quat& r = pose.rotation;
    if (!finite(pose.position) || !finite(r.w) || !finite(r.x) || !finite(r.y) || !finite(r.z))
      return add(field, "must be finite");
    if (const QuaternionCheck bad = check_quaternion(r.w, r.x, r.y, r.z); bad.what) add(field, bad.what, bad.hint);
  }
  // One value for every DoF, or one per DoF.
  void per_dof(const char* field, const Values& values, const KindInfo& kind, bool negative_allowed) {
    if (!finite(values)) return add(field, "must be finite");
    if (values.size() > 1 && values.size() != kind.nv)
      add(field,
          "a " + std::string(kind.name) + " joint has " + counted(kind.nv, "degree") + " of freedom, not " +
              std::to_string(values.size()),
          kind.nv ? "give one number, or one per degree of freedom" : "");
    if (!negative_allowed && std::any_of(values.begin(), values.end(), [](double a) { return a < 0; }))
      add(field, "must not be negative");
  }

  void limits(const JointLimits& l, const KindInfo& kind) {
    if (!l.any()) return;
    if (kind.nq != kind.nv || kind.nv == 0)
      return add("limits", "a " + std::string(kind.name) + " joint has no coordinates that could be limited");
    for (const auto& [side, values] : {std::pair{"lower", &l.lower}, {"upper", &l.upper}}) {
      if (values->size() > 1 && values->size() != kind.nv)
        return add("limits",
                   "a " + std::string(kind.name) + " joint has " + counted(kind.nv, "degree") + " of freedom, but '" + side +
                       "' has " + std::to_string(values->size()) + " numbers",
                   "give one number, or one per degree of freedom; inf for no stop");
      if (std::any_of(values->begin(), values->end(), [](double x) { return std::isnan(x); }))
        return add("limits", std::string("'") + side + "' must be a number");
    }
    for (int i = 0; i < kind.nv; ++i)
      if (!(l.lower_of(i) < l.upper_of(i))) return add("limits", "'lower' must be less than 'upper'");
    per_dof("limits", l.restitution, kind, false);
    if (std::any_of(l.restitution.begin(), l.restitution.end(), [](double e) { return e > 1; }))
      add("limits", "a restitution above 1 would create energy", "0 is plastic, 1 elastic");
    if (!(l.rest_speed > 0) || !std::isfinite(l.rest_speed)) add("limits", "'rest_speed' must be positive");
    counted_values("limits", "stiffness", l.stiffness, kind);
    counted_values("limits", "damping", l.damping, kind);
    if (std::any_of(l.stiffness.begin(), l.stiffness.end(), [](double k) { return k == 0; }))
      add("limits", "a stop without 'stiffness' holds nothing", "leave 'stiffness' out for a hard stop");
    if (!l.damping.empty() && l.stiffness.empty())
      add("limits", "'damping' belongs to a soft stop, which needs 'stiffness'", "for a hard stop give 'restitution' instead");
    if (!l.restitution.empty() && !l.stiffness.empty())
      add("limits", "a stop is hard, with 'restitution', or soft, with 'stiffness' and 'damping', not both",
          "leave one of them out");
  }

  void friction(const JointFriction& f, const KindInfo& kind) {
    counted_values("friction", "coulomb", f.coulomb, kind);
    counted_values("friction", "speed", f.speed, kind);
    if (f.coulomb.empty() && !f.speed.empty()) add("friction", "'speed' alone defines no friction", "give 'coulomb' too");
    for (int i = 0; i < kind.nv; ++i)
      if (f.coulomb.of(i) > 0 && !(f.speed.of(i) > 0))
        return add("friction", "needs a 'speed', over which it builds up",
                   "a small part of the speeds at which it slides, for example 1e-3");
  }

  // Only for kinds whose coordinates can have a target.
  bool has_rates(const char* field, const char* what, const KindInfo& kind) {
    const bool has = kind.nq == kind.nv && kind.nv > 0;
    if (!has)
      add(field, std::string(what) + " needs coordinates whose rates are the velocities, which a " + kind.name + " joint lacks",
          kind.nv == 0 ? "" : "give efforts, one per degree of freedom");
    return has;
  }
  void signals(const char* what, const std::vector<Signal>& list, const KindInfo& kind) {
    if (list.size() > 1 && static_cast<int>(list.size()) != kind.nv)
      add("drive",
          "a " + std::string(kind.name) + " joint has " + counted(kind.nv, "degree") + " of freedom, but '" + what + "' has " +
              std::to_string(list.size()) + " entries",
          kind.nv ? "give one, or one per degree of freedom" : "");
    if (std::any_of(list.begin(), list.end(), [](const Signal& s) { return !finite(s.offset()); }))
      add("drive", std::string("'") + what + "' must be finite");
  }
  void drive(const JointParameters& p, const KindInfo& kind) {
    per_dof("drive", p.effort, kind, true);
    if (p.effort.size() == 1 && kind.nv > 1) one_effort_for_many(kind);
    if (p.drive == nullptr) return;
    const JointDrive& d = *p.drive;
    if (kind.nv == 0 && (!d.effort.empty() || d.pd.any() || d.moves()))
      return add("drive", "a " + std::string(kind.name) + " joint has no degree of freedom to drive");
    signals("effort", d.effort, kind);
    if (d.effort.size() == 1 && kind.nv > 1) one_effort_for_many(kind);
    if (d.moves()) return motion(p, kind);
    if (!d.pd.any()) {
      if (!d.pd.target.empty() || !d.pd.target_speed.empty() || !d.pd.max_effort.empty())
        add("drive", "position control needs 'kp' or 'kd'");
      return;
    }
    if (!has_rates("drive", "position control", kind)) return;
    counted_values("drive", "kp", d.pd.kp, kind);
    counted_values("drive", "kd", d.pd.kd, kind);
    counted_values("drive", "max_effort", d.pd.max_effort, kind, true);
    signals("target", d.pd.target, kind);
    signals("target_speed", d.pd.target_speed, kind);
  }
  void motion(const JointParameters& p, const KindInfo& kind) {
    if (kind.nq != 1 || kind.nv != 1)
      return add("drive",
                 "a motion needs a joint with one degree of freedom; a " + std::string(kind.name) + " joint has " +
                     std::to_string(kind.nv),
                 "use a chain of joints with one degree of freedom each, with massless bodies between them");
    if (p.drive->motion.size() != 1) return add("drive", "give one motion for the one degree of freedom");
    if (!finite(p.drive->motion[0].signal().offset())) add("drive", "'motion' must be finite");
    if (p.effort.any() || !p.drive->effort.empty() || p.drive->pd.any())
      add("drive", "a joint whose motion is prescribed takes the effort that it needs", "leave 'effort' and 'pd' out");
    if (p.limits.any())
      add("drive", "a joint whose motion is prescribed can't be stopped by limits", "leave 'limits' out, or drive by 'pd'");
  }
  void one_effort_for_many(const KindInfo& kind) {
    add("drive", "one effort for " + counted(kind.nv, "degree") + " of freedom is ambiguous",
        "give a list, one effort per degree of freedom");
  }

  void strength(const JointStrength& s) {
    if (!(s.force > 0) || !(s.torque > 0)) add("strength", "must be positive", "leave it out if the joint never breaks");
  }

  // A member of a table: one value for every DoF, or one per DoF; never negative.
  void counted_values(const char* field, const char* member, const Values& values, const KindInfo& kind, bool infinite = false) {
    if (values.size() > 1 && values.size() != kind.nv)
      add(field,
          "a " + std::string(kind.name) + " joint has " + counted(kind.nv, "degree") + " of freedom, but '" + member + "' has " +
              std::to_string(values.size()) + " numbers",
          kind.nv ? "give one number, or one per degree of freedom" : "");
    for (double a : values) {
      if (std::isnan(a) || (!infinite && !finite(a))) return add(field, std::string("'") + member + "' must be finite");
      if (a < 0) return add(field, std::string("'") + member + "' must not be negative");
    }
  }

  std::vector<Problem> problems;
};

}  // namespace

std::vector<JointProblem> check_joint(const JointSpec& joint) {
  Checks<JointProblem> checks;
  const KindInfo& kind = info(joint.kind);
  if (kind.axis) checks.axis("axis", joint.axis);
  if (kind.axis2) checks.axis("axis2", joint.axis2);
  if (kind.axis2 && checks.problems.empty() && parallel(joint.axis, joint.axis2))
    checks.add("axis2", "is parallel to 'axis': that would be the same degree of freedom twice",
               "for example perpendicular to it");
  if (kind.pitch && !finite(joint.pitch)) checks.add("pitch", "must be finite");
  if (kind.pitch && joint.pitch == 0) checks.add("pitch", "a pitch of zero does not move along the axis", "use a revolute joint");

  const JointParameters& p = joint.parameters;
  checks.per_dof("damping", p.damping, kind, false);
  checks.per_dof("stiffness", p.stiffness, kind, false);
  checks.per_dof("armature", p.armature, kind, false);
  checks.drive(p, kind);
  checks.coordinates("rest", p.rest, kind);
  checks.limits(p.limits, kind);
  checks.friction(p.friction, kind);
  checks.strength(p.strength);
  return checks.problems;
}

std::vector<BodyProblem> check_body(const BodySpec& spec) {
  Checks<BodyProblem> checks;
  const KindInfo& kind = info(spec.joint.kind);
  if (spec.name.empty()) checks.add("name", "a body needs a name", "for example \"arm/1\"");
  checks.name("name", spec.name);
  checks.name("joint_name", spec.joint_name);
  if (!finite(spec.mass)) checks.add("mass", "must be finite");
  if (spec.mass < 0) checks.add("mass", "must not be negative");
  const Sym3& i = spec.inertia;
  if (!finite(Vec3{i.xx, i.yy, i.zz}) || !finite(Vec3{i.xy, i.xz, i.yz})) checks.add("inertia", "must be finite");
  if (!finite(spec.com)) checks.add("com", "must be finite");
  checks.placement("at", spec.at);
  checks.placement("child_at", spec.child_at);
  checks.coordinates("q", spec.q, kind);
  if (!finite(spec.v)) checks.add("v", "must be finite");
  if (!spec.v.empty() && spec.v.size() != kind.nv)
    checks.add("v", "a " + std::string(kind.name) + " joint has " + std::to_string(kind.nv) +
                        (kind.nv == 1 ? " velocity" : " velocities") + ", not " + std::to_string(spec.v.size()));
  const JointLimits& l = spec.joint.parameters.limits;
  const std::vector<JointProblem> of_joint = check_joint(spec.joint);
  for (int k = 0; l.hard() && of_joint.empty() && k < std::min(spec.q.size(), kind.nv); ++k)
    if (spec.q[k] < l.lower_of(k) || spec.q[k] > l.upper_of(k)) checks.add("q", "starts beyond its limits");
  for (const JointProblem& problem : of_joint) checks.add(problem.field.c_str(), problem.what, problem.hint);
  return std::move(checks.problems);
}

std::vector<BodyProblem> check_loop(const LoopSpec& spec, int bodies) {
  Checks<BodyProblem> checks;
  checks.name("name", spec.name);
  const auto known = [bodies](BodyId body) { return body.index >= 0 && body.index < bodies; };
  if (spec.body == ground)
    checks.add("body", "the ground can't be the child of a joint",
               spec.to == ground ? "name a body" : "give the other body, leave 'to' out, and exchange 'at' and 'child_at'");
  else if (!known(spec.body))
    checks.add("body", "is not a body of this model", "give what add() returned for the body");
  if (!(spec.to == ground) && !known(spec.to)) checks.add("to", "is not a body of this model", "leave it out for the ground");
  if (known(spec.body) && spec.body == spec.to)
    checks.add("to", "a loop can't join a body to itself", "name another body, or leave 'to' out for the ground");
  if (spec.joint.kind == Kind::free)
    checks.add("kind", "a free joint constrains nothing, so it can't close a loop",
               "use any other kind; for a spring between two bodies use [[spring]]");
  checks.placement("at", spec.at);
  checks.placement("child_at", spec.child_at);
  for (const JointProblem& problem : check_joint(spec.joint)) checks.add(problem.field.c_str(), problem.what, problem.hint);
  return std::move(checks.problems);
}

}  // namespace momentree
