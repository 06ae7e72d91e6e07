#include <momentree/io/state_joint.hpp>

#include <cmath>
#include <limits>
#include <string_view>

#include <momentree/io/parameters_json.hpp>

namespace momentree::io {

namespace {

using Type = JsonNode::Type;

bool near(double a, double b) { return std::isfinite(a - b) && std::fabs(a - b) <= 1e-9 * std::max(1.0, std::fabs(b)); }

struct Same {
  bool exact;
  bool operator()(double a, double b) const { return exact ? a == b : a == b || near(a, b); }
  bool operator()(const Vec3& a, const Vec3& b) const { return (*this)(a.x, b.x) && (*this)(a.y, b.y) && (*this)(a.z, b.z); }
  bool operator()(const Quat& a, const Quat& b) const {
    const double s = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -1 : 1;
    return (*this)(a.w, s * b.w) && (*this)(a.x, s * b.x) && (*this)(a.y, s * b.y) && (*this)(a.z, s * b.z);
  }
  bool operator()(const Pose& a, const Pose& b) const {
    return (*this)(a.position, b.position) && (*this)(a.rotation, b.rotation);
  }
  // One number applies to all; absent is zero (if `exact`, an absent list equals only an absent one).
  bool operator()(const Values& a, const Values& b) const {
    if (exact) return a == b;
    const auto at = [](const Values& values, int i) { return values.empty() ? 0 : values[values.size() == 1 ? 0 : i]; };
    if (a.size() > 1 && b.size() > 1 && a.size() != b.size()) return false;
    for (int i = 0; i < std::max(a.size(), b.size()); ++i)
      if (!(*this)(at(a, i), at(b, i))) return false;
    return true;
  }
  // Written values read back to the same bits, so no tolerance is needed.
  static bool same_drives(const JointDrive* a, const JointDrive* b) {
    const JointDrive none;
    return (a != nullptr ? *a : none) == (b != nullptr ? *b : none);
  }
  bool operator()(const JointParameters& a, const JointParameters& b) const {
    return (*this)(a.damping, b.damping) && (*this)(a.stiffness, b.stiffness) && (*this)(a.rest, b.rest) &&
           (*this)(a.armature, b.armature) && (*this)(a.effort, b.effort) && (*this)(a.limits.lower, b.limits.lower) &&
           (*this)(a.limits.upper, b.limits.upper) && (*this)(a.limits.restitution, b.limits.restitution) &&
           (*this)(a.limits.rest_speed, b.limits.rest_speed) && (*this)(a.limits.stiffness, b.limits.stiffness) &&
           (*this)(a.limits.damping, b.limits.damping) && (*this)(a.friction.coulomb, b.friction.coulomb) &&
           (*this)(a.friction.speed, b.friction.speed) && (*this)(a.strength.force, b.strength.force) &&
           (*this)(a.strength.torque, b.strength.torque) && same_drives(a.drive.get(), b.drive.get());
  }
};

// A length of one up to rounding: accepted unchanged; nearly one: normalised; otherwise refused.
template <class Number>
bool make_unit(Number* x, int n) {
  double length = 0;
  for (int i = 0; i < n; ++i) length = std::hypot(length, x[i]);
  if (!(std::fabs(length - 1) <= 1e-6)) return false;
  if (std::fabs(length - 1) > 1e-12)
    for (int i = 0; i < n; ++i) x[i] /= length;
  return true;
}

}  // namespace

BodyId JointReader::body_named(const std::string& name, const JsonNode& node) const {
  if (model_.has_body(name)) return model_.body(name);
  std::vector<std::string> known;
  for (const BodySpec& body : model_.bodies()) known.push_back(body.name);
  doc_.fail_at(node, "unknown body '" + name + "'", did_you_mean(name, known));
}

Vec3 JointReader::vector(const JsonNode& node, const char* what) const {
  const std::vector<double> x = doc_.numbers(node, what);
  if (x.size() != 3) doc_.fail_at(node, std::string(what) + " should have 3 numbers, not " + std::to_string(x.size()));
  return {x[0], x[1], x[2]};
}

Pose JointReader::pose(const JsonNode& node, const char* what) const {
  doc_.require_known(doc_.object(node, what), {"xyz", "quat"});
  Pose pose;
  if (const JsonNode* xyz = node.find("xyz")) pose.position = vector(*xyz, "`xyz`");
  if (const JsonNode* quat = node.find("quat")) {
    std::vector<double> q = doc_.numbers(*quat, "`quat`");
    if (q.size() != 4) doc_.fail_at(*quat, "`quat` should have 4 numbers: w, x, y, z");
    if (!make_unit(q.data(), 4)) doc_.fail_at(*quat, "the quaternion in `quat` should have length 1");
    pose.rotation = {q[0], q[1], q[2], q[3]};
  }
  return pose;
}

// `locked`: true, false, or one boolean per DoF; `resting`: per DoF 1 on its upper stop, -1 on its lower stop, 0 on none.
void JointReader::read_locks(const JsonNode& node, DescribedJoint& joint) const {
  const KindInfo& kind = info(joint.joint.kind);
  const auto count = static_cast<std::size_t>(kind.nv);
  const auto expect = [&](const JsonNode& list, const char* key) {
    if (list.items.size() != count)
      doc_.fail_at(list, '`' + std::string(key) + "` should have one entry per degree of freedom, " + std::to_string(count) +
                             ", not " + std::to_string(list.items.size()));
  };
  if (const JsonNode* locked = node.find("locked")) {
    if (locked->is(Type::boolean)) {
      joint.joint.locked = locked->number != 0 ? (1u << count) - 1 : 0;
    } else {
      expect(doc_.array(*locked, "`locked`"), "locked");
      for (std::size_t i = 0; i < count; ++i) {
        if (!locked->items[i].is(Type::boolean)) doc_.fail_at(locked->items[i], "`locked` should be true or false");
        if (locked->items[i].number != 0) joint.joint.locked |= 1u << i;
      }
    }
  }
  if (const JsonNode* resting = node.find("resting")) {
    expect(doc_.array(*resting, "`resting`"), "resting");
    for (std::size_t i = 0; i < count; ++i) {
      const double side = doc_.number(resting->items[i], "an entry of `resting`");
      if (side != 0 && side != 1 && side != -1)
        doc_.fail_at(resting->items[i], "`resting` should be 1 (the upper stop), -1 (the lower one) or 0");
      if (side == 0) continue;
      if (!joint.parameters.limits.any()) doc_.fail_at(resting->items[i], "a joint without `limits` cannot rest on a stop");
      joint.resting |= 1u << i;
      joint.active_limits.push_back({-1, static_cast<int>(i), static_cast<int>(side)});
    }
    joint.joint.locked |= joint.resting;
  }
}

DescribedJoint JointReader::describe(const std::string& name, const JsonNode& node, const BodySpec* like, BodyId child) const {
  doc_.require_known(node, {"kind", "parent", "child", "at", "child_at", "axis", "axis2", "pitch", "locked", "reversed",
                            "resting", "parameters", "q", "v", "p", "pdot", "a", "reaction"});
  DescribedJoint d;
  d.name = name, d.node = &node, d.child = child;
  d.joint.kind = like != nullptr ? like->joint.kind : Kind::weld;
  if (const JsonNode* kind = node.find("kind")) {
    const KindInfo* known = find_kind(doc_.string(*kind, "`kind`"));
    if (known == nullptr) doc_.fail_at(*kind, "unknown joint kind '" + kind->text + "'");
    d.joint.kind = known->kind;
  } else if (like == nullptr) {
    doc_.fail_at(node, "joint '" + name + "', which the model does not have, has no `kind`");
  }
  const KindInfo& kind = info(d.joint.kind);
  d.parent = like != nullptr ? like->parent : ground;
  if (const JsonNode* parent = node.find("parent"))
    d.parent = parent->is(Type::null) ? ground : body_named(doc_.string(*parent, "`parent`"), *parent);
  if (like != nullptr) d.joint.at = like->at, d.joint.child_at = like->child_at;
  if (const JsonNode* at = node.find("at")) d.joint.at = pose(*at, "`at`");
  if (const JsonNode* at = node.find("child_at")) d.joint.child_at = pose(*at, "`child_at`");
  JointSpec spec;
  const bool alike = like != nullptr && like->joint.kind == kind.kind;
  if (alike) spec = like->joint;
  spec.kind = kind.kind;
  const auto axis = [&](const char* key, Vec3& value) {
    const JsonNode* given = node.find(key);
    if (given == nullptr) return;
    value = vector(*given, key);
    double x[3] = {value.x, value.y, value.z};
    if (!make_unit(x, 3)) doc_.fail_at(*given, '`' + std::string(key) + "` should have length 1");
    value = {x[0], x[1], x[2]};
  };
  axis("axis", spec.axis);
  axis("axis2", spec.axis2);
  if (const JsonNode* pitch = node.find("pitch")) spec.pitch = doc_.number(*pitch, "`pitch`");
  if (const JsonNode* given = node.find("parameters")) spec.parameters = parameters_of(doc_, *given);
  for (const JointProblem& problem : check_joint(spec)) {
    const JsonNode* at = node.find(problem.field) != nullptr ? node.find(problem.field) : node.find("parameters");
    doc_.fail_at(at != nullptr ? *at : node, '`' + problem.field + "` of joint '" + name + "': " + problem.what, problem.hint);
  }
  d.joint.axis = spec.axis, d.joint.axis2 = spec.axis2, d.joint.pitch = spec.pitch;
  d.parameters = spec.parameters;
  if (const JsonNode* reversed = node.find("reversed")) {
    if (!reversed->is(Type::boolean)) doc_.fail_at(*reversed, "`reversed` should be true or false");
    d.reversed = reversed->number != 0;
    if (d.reversed && d.parent == ground)
      doc_.fail_at(*reversed, "joint '" + name + "' is attached to the ground: it cannot be reversed");
  }
  read_locks(node, d);
  return d;
}

const char* JointReader::difference(const DescribedJoint& d, const BodySpec& model, bool exact) const {
  const Same same{exact};
  const KindInfo& kind = info(model.joint.kind);
  if (d.joint.kind != model.joint.kind) return "kind";
  if (d.parent != model.parent) return "parent";
  if (!same(d.joint.at, model.at)) return "at";
  if (!same(d.joint.child_at, model.child_at)) return "child_at";
  if (kind.axis && !same(d.joint.axis, model.joint.axis)) return "axis";
  if (kind.axis2 && !same(d.joint.axis2, model.joint.axis2)) return "axis2";
  if (kind.pitch && !same(d.joint.pitch, model.joint.pitch)) return "pitch";
  if (!same(d.parameters, model.joint.parameters)) return "parameters";
  if ((d.joint.locked & ~d.resting) != 0) return "locked";
  if (d.resting != 0) return "resting";
  return d.reversed ? "reversed" : nullptr;
}

Values JointReader::numbers(const DescribedJoint& joint, const char* key, int count) const {
  Values result;
  const JsonNode* given = joint.node->find(key);
  if (given == nullptr || given->is(Type::null)) return result;
  const std::vector<double> all = doc_.numbers(*given, '`' + std::string(key) + '`');
  if (all.size() != static_cast<std::size_t>(count))
    doc_.fail_at(*given, '`' + std::string(key) + "` of joint '" + joint.name + "' should have " + std::to_string(count) +
                             (count == 1 ? " number, not " : " numbers, not ") + std::to_string(all.size()));
  for (const double x : all) result.push_back(x);
  return result;
}

JointStart JointReader::start(const DescribedJoint& joint, JointId number) const {
  const KindInfo& kind = info(joint.joint.kind);
  JointStart start{number, numbers(joint, "q", kind.nq), numbers(joint, "v", kind.nv), numbers(joint, "p", kind.nv)};
  const std::size_t first = std::string_view(kind.q_units).find('n');
  if (first != std::string_view::npos && !start.q.empty()) {
    double* const w = &start.q[static_cast<int>(first)];
    const double length = std::hypot(std::hypot(w[0], w[1]), std::hypot(w[2], w[3]));
    if (!make_unit(w, 4))
      doc_.fail_at(*joint.node->find("q"), "the quaternion in `q` has length " + std::to_string(length) + ", it should have 1");
  }
  for (int i = 0; i < kind.nv; ++i) {
    if ((joint.joint.locked >> i & 1u) == 0) continue;
    for (const char* key : {"v", "p"})
      if (const Values& rates = key[0] == 'v' ? start.v : start.p; !rates.empty() && rates[i] != 0)
        doc_.fail_at(*joint.node->find(key),
                     '`' + std::string(key) + "` of joint '" + joint.name + "' is not zero for a locked degree of freedom");
  }
  return start;
}

}  // namespace momentree::io
