// Reads the state document and compares it with its model.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include <momentree/base/characters.hpp>
#include <momentree/io/diagnostic.hpp>
#include <momentree/io/state_document.hpp>
#include <momentree/io/state_joint.hpp>

namespace momentree::io {

namespace {

using Type = JsonNode::Type;

class Reader {
 public:
  Reader(const JsonDocument& document, const Model& model, const std::string& mechanism)
      : doc_(document), model_(model), mechanism_(mechanism), joints_(document, model) {
    result_.file = document.file;
  }

  RestoredState read() {
    const JsonNode& root = doc_.object(doc_.root, "a state document");
    const std::vector<std::string> known{"time", "mechanisms", "joints", "bodies", "armed", "integration", "totals"};
    const auto meant = [&known](const auto& member) { return !nearest(member.key, known).empty(); };
    if (!root.members.empty() && std::none_of(root.members.begin(), root.members.end(), meant))
      doc_.fail_at(root, "this is not a state document", "it has none of `time`, `mechanisms`, `joints`, `bodies`");
    doc_.require_known(root, {"time", "mechanisms", "joints", "bodies", "armed", "integration", "totals"});
    const JsonNode* mechanisms = root.find("mechanisms");
    const bool whole = mechanisms != nullptr && mechanism_.empty();
    if (const JsonNode* joints = root.find("joints"))
      for (const auto& [name, node] : doc_.object(*joints, "`joints`").members) {
        const JsonNode& joint = doc_.object(node, "a joint");
        whole ? describe(name, joint) : read_partial(name, joint);
      }
    if (!mechanism_.empty()) return std::move(result_);

    if (const JsonNode* time = root.find("time")) result_.time = doc_.number(*time, "`time`");
    if (const JsonNode* bodies = root.find("bodies"))
      for (const auto& [name, node] : doc_.object(*bodies, "`bodies`").members) joints_.body_named(name, node);
    if (const JsonNode* armed = root.find("armed")) read_armed(*armed);
    if (const JsonNode* integration = root.find("integration")) {
      doc_.require_known(doc_.object(*integration, "`integration`"), {"step", "work"});
      if (const JsonNode* step = integration->find("step")) {
        result_.memory.next_step = doc_.number(*step, "`step`");
        if (!(result_.memory.next_step > 0)) doc_.fail_at(*step, "`step` should be positive");
      }
      if (const JsonNode* work = integration->find("work")) result_.memory.work = doc_.number(*work, "`work`");
    }
    if (whole) read_forest(*mechanisms);
    return std::move(result_);
  }

 private:
  const BodySpec& spec(BodyId body) const { return model_[body]; }

  bool in_mechanism(BodyId body) const {
    while (spec(body).parent != ground) body = spec(body).parent;
    return model_.mechanism_name(body) == mechanism_;
  }

  /// For an incomplete document, or for one mechanism of a complete one: joints must be as in the model.
  void read_partial(const std::string& name, const JsonNode& node) {
    if (!model_.has_joint(name)) {
      if (!mechanism_.empty() && !name.starts_with(mechanism_ + "/")) return;
      std::vector<std::string> known;
      for (const BodySpec& body : model_.bodies()) known.push_back(body.joint_name);
      std::string hint = did_you_mean(name, known);
      if (hint.empty() && model_.has_body(name))
        hint = "a body of that name exists: a joint that broke is restored by a complete document, with `mechanisms`";
      doc_.fail_at(node, "unknown joint '" + name + "'", hint);
    }
    const JointId number = model_.joint(name);
    const BodyId child = model_.child(number);
    if (!mechanism_.empty() && !in_mechanism(child)) return;
    const DescribedJoint joint = joints_.describe(name, node, &spec(child), child);
    if (const char* key = joints_.difference(joint, spec(child), false))
      doc_.fail_at(*node.find(key), '`' + std::string(key) + "` of joint '" + name + "' is not that of the model",
                   "what has changed is restored by a complete document, with `mechanisms`");
    result_.joints.push_back(joints_.start(joint, number));
    result_.where.push_back(doc_.where(node));
  }

  /// A joint or a mechanism that is not in the model gets its name from the document alone.
  void require_name(const std::string& name, const JsonNode& node, const char* what) const {
    if (name.empty() || name.size() > 500 || name.find_first_of(",\"*") != std::string::npos ||
        first_invisible(name) != std::string::npos)
      doc_.fail_at(node, std::string(what) + " cannot be named " + in_quotes(name),
                   "a name has no , \" * and no invisible characters");
  }

  void describe(const std::string& name, const JsonNode& node) {
    require_name(name, node, "a joint");
    const BodyId declared = model_.has_joint(name) ? model_.child(model_.joint(name)) : ground;
    const BodySpec* like = declared != ground ? &spec(declared) : nullptr;
    BodyId child = declared;
    if (const JsonNode* given = node.find("child")) child = joints_.body_named(doc_.string(*given, "`child`"), *given);
    if (child == ground) doc_.fail_at(node, "joint '" + name + "', which the model does not have, has no `child`");
    if (like != nullptr && child != declared) like = nullptr;
    described_.push_back(joints_.describe(name, node, like, child));
  }

  int read_count(const JsonNode& node) const {
    const JsonNode* fired = node.find("fired");
    const double count = fired != nullptr ? doc_.number(*fired, "`fired`") : 0;
    if (!(count >= 0 && count <= std::numeric_limits<int>::max()) || count != std::floor(count))
      doc_.fail_at(*fired, "`fired` should be a count");
    return static_cast<int>(count);
  }

  bool truth(const JsonNode& node, const char* key) const {
    const JsonNode* given = node.find(key);
    if (given != nullptr && !given->is(Type::boolean)) doc_.fail_at(*given, '`' + std::string(key) + "` should be true or false");
    return given != nullptr && given->number != 0;
  }

  EventStatus read_condition(const JsonNode& node) const {
    EventStatus armed;
    armed.fired = read_count(node);
    armed.done = truth(node, "done"), armed.resting = truth(node, "resting");
    const JsonNode *due = node.find("due"), *since = node.find("since"), *looked = node.find("looked");
    armed.time = due != nullptr ? doc_.number(*due, "`due`") : std::numeric_limits<double>::infinity();
    if (since != nullptr) armed.since = doc_.number(*since, "`since`");
    if (looked == nullptr) return armed;
    const auto& looks = doc_.array(*looked, "`looked`").items;
    if (looks.empty() || looks.size() > 2) doc_.fail_at(*looked, "`looked` should have one or two entries: [time, excess]");
    const auto read_sample = [&](const JsonNode& item, double& time, double& excess) {
      const std::vector<double> pair = doc_.numbers(item, "an entry of `looked`");
      if (pair.size() != 2) doc_.fail_at(item, "an entry of `looked` should be [time, excess]");
      time = pair[0], excess = pair[1];
    };
    read_sample(looks.back(), armed.looked, armed.excess);
    if (looks.size() == 2) read_sample(looks.front(), armed.looked_before, armed.excess_before);
    return armed;
  }

  void read_armed(const JsonNode& armed) {
    for (const auto& [name, node] : doc_.object(armed, "`armed`").members) {
      doc_.require_known(doc_.object(node, "an entry of `armed`"),
                         {"fired", "done", "due", "since", "resting", "looked", "each"});
      ArmedEvent event{name, read_count(node)};
      if (const JsonNode* each = node.find("each")) {
        for (const JsonNode& item : doc_.array(*each, "`each`").items) {
          doc_.require_known(doc_.object(item, "an entry of `each`"), {"fired", "done", "due", "since", "resting", "looked"});
          event.each.push_back(read_condition(item));
        }
      } else if (node.members.size() > 1) {
        event.each.push_back(read_condition(node));
      }
      result_.armed.push_back(std::move(event));
    }
  }

  void read_forest(const JsonNode& mechanisms) {
    const std::vector<int> numbers = number_joints();
    attach_bodies(numbers, mechanisms);
    for (std::size_t k = 0; k < described_.size(); ++k) take(described_[k], numbers[k]);
    std::sort(result_.forest.changed.begin(), result_.forest.changed.end(),
              [](const Forest::Changed& a, const Forest::Changed& b) { return a.joint < b.joint; });
    read_mechanisms(mechanisms);
  }

  /// A joint that connects the same bodies as the model's joint of that name gets its number; the others get the remaining
  /// numbers in the order of the document, in which they were written.
  std::vector<int> number_joints() const {
    std::vector<char> taken(model_.bodies().size(), 0);
    std::vector<int> numbers;
    for (const DescribedJoint& joint : described_) {
      const BodyId same = model_.has_joint(joint.name) ? model_.child(model_.joint(joint.name)) : ground;
      const bool ours = same != ground && same == joint.child && spec(same).parent == joint.parent;
      numbers.push_back(ours ? same.index : -1);
      if (ours) taken[static_cast<std::size_t>(same.index)] = 1;
    }
    std::size_t next = 0;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (numbers[k] >= 0) continue;
      while (next < taken.size() && taken[next] != 0) ++next;
      if (next == taken.size()) doc_.fail_at(*described_[k].node, "there are more joints than bodies", "each body has one joint");
      numbers[k] = static_cast<int>(next++);
    }
    return numbers;
  }

  /// Determines the carrying body of each joint, and the parent of that body.
  void attach_bodies(const std::vector<int>& numbers, const JsonNode& mechanisms) {
    const std::size_t n = model_.bodies().size();
    std::vector<Topology::Place>& places = result_.forest.places;
    std::vector<const JsonNode*> joint_of(n, nullptr);
    places.resize(n);
    for (std::size_t k = 0; k < described_.size(); ++k) {
      const DescribedJoint& joint = described_[k];
      const BodyId carrier = joint.reversed ? joint.parent : joint.child, outer = joint.reversed ? joint.child : joint.parent;
      const auto b = static_cast<std::size_t>(carrier.index);
      if (joint_of[b] != nullptr)
        doc_.fail_at(*joint.node, "body '" + spec(carrier).name + "' already has a joint, at " + doc_.where(*joint_of[b]));
      joint_of[b] = joint.node;
      places[b] = {outer.index, numbers[k], joint.reversed};
    }
    for (std::size_t b = 0; b < n; ++b)
      if (joint_of[b] == nullptr)
        doc_.fail_at(mechanisms, "the document has no joint for body '" + model_.bodies()[b].name + "'",
                     "leave `mechanisms` out if the document is not complete");
    enum : char { unseen, on_the_way, seen };
    std::vector<char> state(n, unseen);
    std::vector<std::size_t> way;
    for (std::size_t b = 0; b < n; ++b) {
      int a = static_cast<int>(b);
      for (way.clear(); a >= 0 && state[static_cast<std::size_t>(a)] == unseen; a = places[way.back()].parent) {
        way.push_back(static_cast<std::size_t>(a));
        state[way.back()] = on_the_way;
      }
      if (a >= 0 && state[static_cast<std::size_t>(a)] == on_the_way)
        doc_.fail_at(*joint_of[static_cast<std::size_t>(a)], "the joints form a cycle at body '" + spec({a}).name + "'");
      for (const std::size_t passed : way) state[passed] = seen;
    }
  }

  void take(const DescribedJoint& joint, int number) {
    JointStart start = joints_.start(joint, {number});
    const KindInfo& kind = info(joint.joint.kind);
    if (kind.nq > 0 && start.q.empty())
      doc_.fail_at(*joint.node, "joint '" + joint.name + "' has no `q`", "a complete document gives it for every joint");
    if (kind.nv > 0 && start.v.empty() && start.p.empty())
      doc_.fail_at(*joint.node, "joint '" + joint.name + "' has neither `v` nor `p`",
                   "a complete document gives one of them for every joint");
    result_.joints.push_back(start);
    result_.where.push_back(doc_.where(*joint.node));
    for (ActiveLimit hold : joint.active_limits) {
      hold.joint = number;
      result_.forest.active_limits.push_back(hold);
    }
    const BodySpec& ours = spec({number});
    if (joint.name == ours.joint_name && joint.child.index == number && joint.parent == ours.parent) {
      const char* const key = joints_.difference(joint, ours, true);
      if (key == nullptr || key == std::string_view("reversed")) return;
    }
    Forest::Changed changed{number, joint.name, joint.joint, joint.parameters};
    const auto unmoved = [](const Pose& pose) {
      const Quat& r = pose.rotation;
      return pose.position == Vec3{} && r.x == 0 && r.y == 0 && r.z == 0;
    };
    changed.as.created_by_event = joint.joint.kind == Kind::free && joint.parent == ground && unmoved(joint.joint.at) &&
                                  unmoved(joint.joint.child_at) && joint.parameters == JointParameters{};
    result_.forest.changed.push_back(std::move(changed));
  }

  /// Every body must be in one mechanism, together with the bodies that its joints lead to.
  void read_mechanisms(const JsonNode& mechanisms) {
    const std::vector<Topology::Place>& places = result_.forest.places;
    std::vector<const JsonNode*> mechanism_of(places.size(), nullptr);
    std::set<const JsonNode*> rooted;
    for (const JsonNode& mechanism : doc_.array(mechanisms, "`mechanisms`").items) {
      doc_.require_known(doc_.object(mechanism, "a mechanism"), {"name", "root", "bodies"});
      const JsonNode* bodies = mechanism.find("bodies");
      if (bodies == nullptr) doc_.fail_at(mechanism, "a mechanism has no `bodies`");
      for (const JsonNode& node : doc_.array(*bodies, "`bodies`").items) {
        const BodyId body = joints_.body_named(doc_.string(node, "a body's name"), node);
        const JsonNode*& place = mechanism_of[static_cast<std::size_t>(body.index)];
        if (place != nullptr) doc_.fail_at(node, "body '" + node.text + "' is in two mechanisms, or twice in one");
        place = &mechanism;
      }
    }
    for (std::size_t b = 0; b < places.size(); ++b) {
      const std::string& body = model_.bodies()[b].name;
      if (mechanism_of[b] == nullptr) doc_.fail_at(mechanisms, "body '" + body + "' is in no mechanism");
      const JsonNode *root = mechanism_of[b]->find("root"), *name = mechanism_of[b]->find("name");
      const bool is_root = places[b].parent < 0;
      if (root != nullptr && is_root != (doc_.string(*root, "`root`") == body))
        doc_.fail_at(*root, "`root` does not fit the joints: see body '" + body + "'");
      if (!is_root && mechanism_of[static_cast<std::size_t>(places[b].parent)] != mechanism_of[b])
        doc_.fail_at(*mechanism_of[b], "body '" + body + "' is in another mechanism than the parent of its joint");
      if (is_root && !rooted.insert(mechanism_of[b]).second)
        doc_.fail_at(*mechanism_of[b], "a mechanism has one root, but '" + body + "' is a second one");
      if (is_root && name != nullptr) require_name(doc_.string(*name, "`name`"), *name, "a mechanism");
      if (is_root)
        result_.forest.mechanisms.emplace_back(static_cast<int>(b), name != nullptr ? doc_.string(*name, "`name`") : body);
    }
  }

  const JsonDocument& doc_;
  const Model& model_;
  const std::string& mechanism_;
  JointReader joints_;
  std::vector<DescribedJoint> described_;
  RestoredState result_;
};

}  // namespace

RestoredState read_state(const std::string& text, const std::string& file, const Model& model, const std::string& mechanism) {
  const JsonDocument document = parse_json(text, file);
  return Reader(document, model, mechanism).read();
}

}  // namespace momentree::io
