#include <momentree/scenario/state/state_joint.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

#include <momentree/scenario/keys/joint_keys.hpp>
#include <momentree/scenario/state/parameters_json.hpp>

namespace momentree::io {

namespace {

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
  bool operator()(const std::vector<Signal>& a, const std::vector<Signal>& b) const { return a == b; }
  bool operator()(const JointParameters& a, const JointParameters& b) const {
    JointSettings first(a), second(b);
    return alike(joint_keys(), first, second, *this);
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

std::string JointReader::suggest(const std::string& name, std::string BodySpec::*kind) {
  if (suggestions_left_-- <= 0) return {};
  std::vector<std::string> known;
  for (const BodySpec& body : model_.bodies()) known.push_back(body.*kind);
  return did_you_mean(name, known);
}

std::optional<BodyId> JointReader::body_named(const std::string& name, Place place) {
  if (model_.has_body(name)) return model_.body(name);
  out_.error(place, "unknown body " + in_quotes(name), suggest(name, &BodySpec::name));
  return {};
}

void JointReader::read_pose(Fields& fields, const char* key, Pose& pose) {
  const Value* value = fields.find(key);
  if (!value) return;
  Fields parts(*value, key, out_, "");
  pose = {};
  if (const auto xyz = parts.reals("xyz", 3); !xyz.empty()) pose.position = {xyz[0], xyz[1], xyz[2]};
  if (auto q = parts.reals("quat", 4); !q.empty()) {
    if (!make_unit(q.data(), 4)) out_.error(parts.place_of("quat"), "quat: the length of the quaternion is not 1");
    pose.rotation = {q[0], q[1], q[2], q[3]};
  }
  parts.finish();
}

// `locked`: true, false, or one boolean per DoF; `resting`: per DoF 1 on its upper stop, -1 on its lower stop, 0 on none;
// `stop_forces`: per DoF that of a stop that is stepped through, which locks nothing; `deeper`: per DoF where its lower and its
// upper stop act, if that is beyond their limits.
void JointReader::read_locks(Fields& fields, DescribedJoint& joint) {
  const int count = info(joint.joint.kind).nv;
  const auto list = [&](const Value& value, const char* key) {
    const bool fits = value.array() && value.array()->size() == static_cast<std::size_t>(count);
    if (!fits)
      out_.error(value.place, std::string(key) + ": expected a list with one entry per degree of freedom, " +
                                  std::to_string(count) + ", found " +
                                  (value.array() ? std::to_string(value.array()->size()) : value.type_name()));
    return fits ? value.array() : nullptr;
  };
  if (const Value* locked = fields.find("locked")) {
    if (const bool* all = locked->boolean()) {
      joint.joint.locked = *all ? (1u << count) - 1 : 0;
    } else if (const Value::Array* each = list(*locked, "locked")) {
      for (int i = 0; i < count; ++i) {
        const Value& entry = (*each)[static_cast<std::size_t>(i)];
        if (!entry.boolean()) out_.error(entry.place, std::string("locked: expected true or false, found ") + entry.type_name());
        if (entry.boolean() && *entry.boolean()) joint.joint.locked |= 1u << i;
      }
    }
  }
  const Value* resting = fields.find("resting");
  const Value::Array* sides = resting ? list(*resting, "resting") : nullptr;
  const std::vector<double> forces = fields.reals("stop_forces", static_cast<std::size_t>(count));
  for (int i = 0; i < static_cast<int>(forces.size()); ++i) {
    if (forces[static_cast<std::size_t>(i)] == 0) continue;
    SteppedContact& stop = joint.stepped.emplace_back();
    stop.id = static_cast<std::uint64_t>(i), stop.side = forces[static_cast<std::size_t>(i)] > 0 ? -1 : 1;
    stop.force.x = std::fabs(forces[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; sides && i < count; ++i) {
    const Value& entry = (*sides)[static_cast<std::size_t>(i)];
    const std::optional<double> side = entry.number();
    if (side == 0.0) continue;
    if (side != 1.0 && side != -1.0) {
      out_.error(entry.place, "resting: expected 1 (the upper stop), -1 (the lower one) or 0");
      continue;
    }
    if (!joint.parameters.limits.any()) out_.error(entry.place, "resting: a joint without 'limits' cannot rest on a stop");
    if (!forces.empty()) {
      auto stop = std::ranges::find(joint.stepped, static_cast<std::uint64_t>(i), &SteppedContact::id);
      if (stop == joint.stepped.end()) stop = joint.stepped.emplace(stop), stop->id = static_cast<std::uint64_t>(i);
      stop->side = static_cast<int>(*side), stop->rests = true;
      continue;
    }
    joint.resting |= 1u << i;
    joint.active_limits.push_back({-1, i, static_cast<int>(*side)});
  }
  joint.joint.locked |= joint.resting;
  const Value* deeper = fields.find("deeper");
  const Value::Array* stops = deeper ? list(*deeper, "deeper") : nullptr;
  for (int i = 0; stops && i < count; ++i) {
    const Value& entry = (*stops)[static_cast<std::size_t>(i)];
    const Value::Array* const pair = entry.array();
    for (std::size_t k = 0; k < 2; ++k) {
      const Value* const at = pair && pair->size() == 2 ? &(*pair)[k] : nullptr;
      if (at && at->is_null()) continue;
      const int sign = k == 0 ? -1 : 1;
      if (at && at->number())
        joint.deeper.push_back({-1, i, sign, sign * *at->number()});
      else
        return out_.error(entry.place, "deeper: expected where the lower and the upper stop act, two numbers or null");
    }
  }
}

// Kind, parent, frames, axes and parameters.
void JointReader::read_shape(Fields& fields, DescribedJoint& d, JointSpec& spec, const BodySpec* like) {
  d.parent = like ? like->parent : ground;
  if (const Value* parent = fields.find("parent"); parent && parent->is_null())
    d.parent = ground;
  else if (const auto name = fields.string("parent"))
    d.parent = body_named(*name, parent->place).value_or(ground);
  if (like) d.joint.at = like->at, d.joint.child_at = like->child_at;
  read_pose(fields, "at", d.joint.at);
  read_pose(fields, "child_at", d.joint.child_at);
  const auto read_axis = [&](const char* key, Vec3& axis) {
    std::vector<double> x = fields.reals(key, 3);
    if (x.empty()) return;
    if (!make_unit(x.data(), 3)) out_.error(fields.place_of(key), std::string(key) + ": its length is not 1");
    axis = {x[0], x[1], x[2]};
  };
  read_axis("axis", spec.axis);
  read_axis("axis2", spec.axis2);
  spec.pitch = fields.real("pitch").value_or(spec.pitch);
  const std::size_t errors = out_.errors();
  if (const Value* parameters = fields.find("parameters")) spec.parameters = parameters_of(*parameters, out_);
  if (errors != out_.errors()) return;
  for (const JointProblem& problem : check_joint(spec)) {
    const char* const key = fields.has(problem.field) || !fields.has("parameters") ? problem.field.c_str() : "parameters";
    const Value::Entry* in = fields.find("parameters") ? fields.find("parameters")->find(problem.field) : nullptr;
    out_.error(in ? in->value.place : fields.place_of(key), problem.field + ": " + problem.what, problem.hint);
  }
}

std::optional<DescribedJoint> JointReader::describe(const Value::Entry& entry, const BodySpec* like, BodyId child) {
  const std::size_t errors = out_.errors();
  Fields fields(entry.value, "joint " + in_quotes(entry.key), out_, "");
  if (!entry.value.table()) return {};
  DescribedJoint d;
  d.entry = &entry, d.child = child;
  JointSpec spec;
  if (like) spec = like->joint;
  const KindInfo* kind = like ? &info(like->joint.kind) : nullptr;
  if (const auto name = fields.string("kind"); name && (!kind || *name != kind->name)) {
    spec = JointSpec{};
    kind = find_kind(*name);
    if (!kind) out_.error(fields.place_of("kind"), "unknown joint kind " + in_quotes(*name));
  } else if (!kind && !fields.has("kind")) {
    out_.error(entry.place, "joint " + in_quotes(entry.key) + ", which the model does not have, has no 'kind'");
  }
  if (!kind) return {};
  d.joint.kind = spec.kind = kind->kind;
  read_shape(fields, d, spec, like);
  d.joint.axis = spec.axis, d.joint.axis2 = spec.axis2, d.joint.pitch = spec.pitch;
  d.parameters = spec.parameters;
  d.reversed = fields.boolean("reversed").value_or(false);
  d.loop = fields.boolean("loop").value_or(false);
  d.made = fields.boolean("made").value_or(false);
  if (d.reversed && d.parent == ground && errors == out_.errors())
    out_.error(fields.place_of("reversed"), "reversed: a joint that is attached to the ground cannot be reversed");
  read_locks(fields, d);
  read_start(fields, d);
  for (const char* key : {"child", "pdot", "a", "reaction"}) fields.find(key);
  fields.finish();
  if (errors != out_.errors()) return {};
  return d;
}

Values JointReader::read_values(Fields& fields, const char* key, int count) {
  Values values;
  const Value* given = fields.find(key);
  if (!given || given->is_null()) return values;
  for (const double x : read_reals(*given, static_cast<std::size_t>(count), key, out_)) values.push_back(x);
  return values;
}

void JointReader::read_start(Fields& fields, DescribedJoint& d) {
  const KindInfo& kind = info(d.joint.kind);
  d.q = read_values(fields, "q", kind.nq);
  d.v = read_values(fields, "v", kind.nv);
  if (d.loop)
    fields.find("p");
  else
    d.p = read_values(fields, "p", kind.nv);
  const std::size_t first = std::string_view(kind.q_units).find('n');
  if (first != std::string_view::npos && !d.q.empty() && !make_unit(&d.q[static_cast<int>(first)], 4))
    out_.error(fields.place_of("q"), "q: the length of the quaternion is not 1");
  for (const auto& [key, rates] : {std::pair{"v", &d.v}, {"p", &d.p}})
    for (int i = 0; i < rates->size(); ++i)
      if ((d.joint.locked >> i & 1u) != 0 && (*rates)[i] != 0)
        out_.error(fields.place_of(key), std::string(key) + ": is not zero for a locked degree of freedom");
}

const char* JointReader::difference(const DescribedJoint& d, const BodySpec& model, bool exact) {
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

}  // namespace momentree::io
