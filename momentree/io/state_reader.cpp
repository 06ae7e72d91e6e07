// Reads the state document and holds it against the model that it is for.
#include <cmath>
#include <limits>
#include <string_view>

#include <momentree/io/json_document.hpp>
#include <momentree/io/state_document.hpp>

namespace momentree::io {

namespace {

using Type = JsonNode::Type;

bool near(double a, double b) { return std::fabs(a - b) <= 1e-9 * std::max(1.0, std::fabs(b)); }

class Reader {
 public:
  Reader(const JsonDocument& document, const Model& model, const std::string& mechanism)
      : doc_(document), model_(model), mechanism_(mechanism), entry_of_(model.bodies().size(), nullptr) {
    result_.file = document.file;
  }

  RestoredState read() {
    const JsonNode& root = doc_.object(doc_.root, "a state document");
    doc_.require_known(root, {"time", "mechanisms", "joints", "bodies", "armed", "totals"});
    const JsonNode* mechanisms = root.find("mechanisms");
    whole_ = mechanisms != nullptr && mechanism_.empty();
    if (const JsonNode* joints = root.find("joints"))
      for (const auto& [name, node] : doc_.object(*joints, "`joints`").members) read_joint(name, doc_.object(node, "a joint"));
    if (!mechanism_.empty()) return std::move(result_);

    if (const JsonNode* time = root.find("time")) result_.time = doc_.number(*time, "`time`");
    if (const JsonNode* bodies = root.find("bodies"))
      for (const auto& [name, node] : doc_.object(*bodies, "`bodies`").members) body_named(name, node);
    if (const JsonNode* armed = root.find("armed")) read_armed(*armed);
    if (whole_) check_forest(*mechanisms);
    return std::move(result_);
  }

 private:
  Body body_named(const std::string& name, const JsonNode& node) const {
    if (model_.has_body(name)) return model_.body(name);
    std::vector<std::string> known;
    for (const BodySpec& body : model_.bodies()) known.push_back(body.name);
    doc_.fail_at(node, "unknown body '" + name + "'", did_you_mean(name, known));
  }

  const BodySpec& spec(Body body) const { return model_[body]; }

  bool in_mechanism(Body body) const {
    while (spec(body).parent != ground) body = spec(body).parent;
    return model_.mechanism_name(body) == mechanism_;
  }

  /// The body that a joint of the document carries; index −1: it is of another mechanism than asked for.
  Body child_of(const std::string& name, const JsonNode& node) const {
    if (const JsonNode* child = node.find("child"); child != nullptr && whole_)
      return body_named(doc_.string(*child, "`child`"), *child);
    if (model_.has_joint(name)) {
      const Body body = model_.joint(name);
      return mechanism_.empty() || in_mechanism(body) ? body : ground;
    }
    if (!mechanism_.empty() && !name.starts_with(mechanism_ + "/")) return ground;
    std::vector<std::string> known;
    for (const BodySpec& body : model_.bodies()) known.push_back(body.joint_name);
    std::string hint = did_you_mean(name, known);
    if (hint.empty() && !whole_ && model_.has_body(name))
      hint = "a body of that name is there: a joint that broke is restored by a whole document, with `mechanisms`";
    doc_.fail_at(node, "unknown joint '" + name + "'", hint);
  }

  Vec3 vector(const JsonNode& node, std::string_view what) const {
    const std::vector<double> x = doc_.numbers(node, what);
    if (x.size() != 3) doc_.fail_at(node, std::string(what) + " should have 3 numbers, not " + std::to_string(x.size()));
    return {x[0], x[1], x[2]};
  }
  static bool same(const Vec3& a, const Vec3& b) { return near(a.x, b.x) && near(a.y, b.y) && near(a.z, b.z); }

  bool same_pose(const JsonNode& node, const char* what, const Pose& pose) const {
    doc_.require_known(doc_.object(node, what), {"xyz", "quat"});
    if (const JsonNode* xyz = node.find("xyz"); xyz != nullptr && !same(vector(*xyz, "`xyz`"), pose.position)) return false;
    const JsonNode* quat = node.find("quat");
    if (quat == nullptr) return true;
    const std::vector<double> q = doc_.numbers(*quat, "`quat`");
    if (q.size() != 4) doc_.fail_at(*quat, "`quat` should have 4 numbers: w, x, y, z");
    const Quat& r = pose.rotation;
    return near(std::fabs(q[0] * r.w + q[1] * r.x + q[2] * r.y + q[3] * r.z), 1);
  }

  bool same_parameter(const JsonNode& parameters, const char* key, const Values& ours) const {
    const JsonNode* node = parameters.find(key);
    std::vector<double> theirs;
    if (node != nullptr && node->is(Type::number))
      theirs = {node->number};
    else if (node != nullptr)
      theirs = doc_.numbers(*node, key);
    const std::size_t n = std::max(theirs.size(), static_cast<std::size_t>(ours.size()));
    for (std::size_t i = 0; i < n; ++i) {
      const double a = theirs.empty() ? 0 : theirs[theirs.size() == 1 ? 0 : i];
      const double b = ours.empty() ? 0 : ours[ours.size() == 1 ? 0 : static_cast<int>(i)];
      if (!near(a, b)) return false;
    }
    return true;
  }

  /// The first thing that the document says of a joint and that is not so in the model: its key, or null.
  const char* difference(const JsonNode& node, Body body) const {
    const BodySpec& ours = spec(body);
    if (const JsonNode* kind = node.find("kind"); kind != nullptr && doc_.string(*kind, "`kind`") != info(ours.joint.kind).name)
      return "kind";
    if (const JsonNode* parent = node.find("parent")) {
      const std::string name = parent->is(Type::null) ? "" : doc_.string(*parent, "`parent`");
      if (name != (ours.parent == ground ? "" : spec(ours.parent).name)) return "parent";
    }
    if (const JsonNode* at = node.find("at"); at != nullptr && !same_pose(*at, "`at`", ours.at)) return "at";
    if (const JsonNode* at = node.find("child_at"); at != nullptr && !same_pose(*at, "`child_at`", ours.child_at))
      return "child_at";
    if (const JsonNode* axis = node.find("axis"); axis != nullptr && !same(vector(*axis, "`axis`"), ours.joint.axis))
      return "axis";
    if (const JsonNode* axis = node.find("axis2"); axis != nullptr && !same(vector(*axis, "`axis2`"), ours.joint.axis2))
      return "axis2";
    if (const JsonNode* pitch = node.find("pitch"); pitch != nullptr && !near(doc_.number(*pitch, "`pitch`"), ours.joint.pitch))
      return "pitch";
    if (const JsonNode* p = node.find("parameters")) {
      doc_.require_known(doc_.object(*p, "`parameters`"), {"damping", "stiffness", "rest", "armature", "effort"});
      const JointParameters& o = ours.joint.parameters;
      if (!same_parameter(*p, "damping", o.damping) || !same_parameter(*p, "stiffness", o.stiffness) ||
          !same_parameter(*p, "rest", o.rest) || !same_parameter(*p, "armature", o.armature) ||
          !same_parameter(*p, "effort", o.effort))
        return "parameters";
    }
    return nullptr;
  }

  /// What a break leaves: a free joint to the ground that is named after the body.
  static bool looks_broken(const std::string& name, const JsonNode& node, const BodySpec& body) {
    const JsonNode *kind = node.find("kind"), *parent = node.find("parent");
    return name == body.name && kind != nullptr && kind->text == info(Kind::free).name &&
           (parent == nullptr || parent->is(Type::null));
  }

  Values values(const JsonNode& joint, const char* key, int count, const std::string& name) const {
    Values result;
    const JsonNode* node = joint.find(key);
    if (node == nullptr || node->is(Type::null)) return result;
    const std::vector<double> numbers = doc_.numbers(*node, '`' + std::string(key) + '`');
    if (numbers.size() != static_cast<std::size_t>(count))
      doc_.fail_at(*node, '`' + std::string(key) + "` of joint '" + name + "' should have " + std::to_string(count) +
                              " numbers, not " + std::to_string(numbers.size()));
    for (const double x : numbers) result.push_back(x);
    return result;
  }

  void check_quaternion(const JsonNode& joint, const KindInfo& kind, Values& q) const {
    const std::size_t first = std::string_view(kind.q_units).find('n');
    if (first == std::string_view::npos || q.empty()) return;
    const int w = static_cast<int>(first);
    const double length = std::hypot(std::hypot(q[w], q[w + 1]), std::hypot(q[w + 2], q[w + 3]));
    if (!(std::fabs(length - 1) <= 1e-6))
      doc_.fail_at(*joint.find("q"), "the quaternion in `q` has length " + std::to_string(length) + ", it should have 1");
    if (std::fabs(length - 1) > 1e-12)
      for (int i = w; i < w + 4; ++i) q[i] /= length;
  }

  void read_joint(const std::string& name, const JsonNode& node) {
    doc_.require_known(node, {"kind", "parent", "child", "at", "child_at", "axis", "axis2", "pitch", "locked", "reversed",
                              "parameters", "q", "v", "p", "pdot", "a", "reaction"});
    const Body body = child_of(name, node);
    if (body == ground) return;
    const JsonNode*& entry = entry_of_[static_cast<std::size_t>(body.index)];
    if (entry != nullptr) doc_.fail_at(node, "body '" + spec(body).name + "' has a joint already, at " + doc_.where(*entry));
    entry = &node;
    for (const char* flag : {"locked", "reversed"})
      if (const JsonNode* value = node.find(flag); value != nullptr && value->number != 0)
        doc_.fail_at(*value, '`' + std::string(flag) + "` joints are not supported yet");

    const char* key = difference(node, body);
    const bool renamed = name != spec(body).joint_name;
    const bool broken = whole_ && (key != nullptr || renamed) && looks_broken(name, node, spec(body));
    if (key != nullptr && !broken)
      doc_.fail_at(*node.find(key),
                   '`' + std::string(key) + "` of joint '" + name + "' is not that of the model: the document is of another one");
    if (renamed && !broken)
      doc_.fail_at(node, "the joint of body '" + spec(body).name + "' is '" + spec(body).joint_name + "' in the model, not '" +
                             name + "'");
    if (broken) result_.broken.push_back(body);

    const KindInfo& kind = info(broken ? Kind::free : spec(body).joint.kind);
    JointStart start{body, values(node, "q", kind.nq, name), values(node, "v", kind.nv, name), values(node, "p", kind.nv, name)};
    check_quaternion(node, kind, start.q);
    if (whole_ && kind.nq > 0 && start.q.empty())
      doc_.fail_at(node, "joint '" + name + "' has no `q`", "a whole document gives it for every joint");
    if (whole_ && kind.nv > 0 && start.v.empty() && start.p.empty())
      doc_.fail_at(node, "joint '" + name + "' has neither `v` nor `p`", "a whole document gives one of them for every joint");
    result_.joints.push_back(start);
    result_.where.push_back(doc_.where(node));
  }

  void read_armed(const JsonNode& armed) {
    for (const auto& [name, node] : doc_.object(armed, "`armed`").members) {
      doc_.require_known(doc_.object(node, "an entry of `armed`"), {"fired"});
      const JsonNode* fired = node.find("fired");
      const double count = fired != nullptr ? doc_.number(*fired, "`fired`") : 0;
      if (!(count >= 0 && count <= std::numeric_limits<int>::max()) || count != std::floor(count))
        doc_.fail_at(*fired, "`fired` should be a count");
      result_.armed.emplace_back(name, static_cast<int>(count));
    }
  }

  /// Every body in one mechanism, with the one that its joint leads to.
  void check_forest(const JsonNode& mechanisms) {
    const auto n = model_.bodies().size();
    for (std::size_t b = 0; b < n; ++b)
      if (entry_of_[b] == nullptr)
        doc_.fail_at(mechanisms, "the document has no joint for body '" + model_.bodies()[b].name + "'",
                     "leave `mechanisms` out where the document does not say everything");
    std::vector<bool> is_broken(n, false);
    for (const Body body : result_.broken) is_broken[static_cast<std::size_t>(body.index)] = true;
    std::vector<const JsonNode*> mechanism_of(n, nullptr);
    for (const JsonNode& mechanism : doc_.array(mechanisms, "`mechanisms`").items) {
      doc_.require_known(doc_.object(mechanism, "a mechanism"), {"name", "root", "bodies"});
      const JsonNode* bodies = mechanism.find("bodies");
      if (bodies == nullptr) doc_.fail_at(mechanism, "a mechanism has no `bodies`");
      for (const JsonNode& node : doc_.array(*bodies, "`bodies`").items) {
        const JsonNode*& place =
            mechanism_of[static_cast<std::size_t>(body_named(doc_.string(node, "a body's name"), node).index)];
        if (place != nullptr) doc_.fail_at(node, "body '" + node.text + "' is in two mechanisms, or twice in one");
        place = &mechanism;
      }
    }
    for (std::size_t b = 0; b < n; ++b) {
      const BodySpec& body = model_.bodies()[b];
      if (mechanism_of[b] == nullptr) doc_.fail_at(mechanisms, "body '" + body.name + "' is in no mechanism");
      const JsonNode* root = mechanism_of[b]->find("root");
      const bool is_root = is_broken[b] || body.parent == ground;
      if (root != nullptr && is_root != (doc_.string(*root, "`root`") == body.name))
        doc_.fail_at(*root, "`root` does not fit the joints: see body '" + body.name + "'");
      if (!is_root && mechanism_of[static_cast<std::size_t>(body.parent.index)] != mechanism_of[b])
        doc_.fail_at(*mechanism_of[b], "body '" + body.name + "' is in another mechanism than the parent of its joint");
    }
  }

  const JsonDocument& doc_;
  const Model& model_;
  const std::string& mechanism_;
  bool whole_ = false;
  std::vector<const JsonNode*> entry_of_;
  RestoredState result_;
};

}  // namespace

RestoredState read_state(const std::string& text, const std::string& file, const Model& model, const std::string& mechanism) {
  const JsonDocument document = parse_json(text, file);
  return Reader(document, model, mechanism).read();
}

}  // namespace momentree::io
