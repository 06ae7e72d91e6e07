// Reads the state document and compares it with its model.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/state/state_contact.hpp>
#include <momentree/scenario/state/state_coupling.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/state/state_joint.hpp>
#include <momentree/scenario/state/state_spring.hpp>
#include <momentree/text/json.hpp>

namespace momentree::io {

namespace {

const char* const whole_document = "what has changed is restored by a complete document, with `mechanisms`";

class Reader {
 public:
  Reader(std::string file, const Model& model, const std::string& mechanism, Diagnostics& out)
      : model_(model), mechanism_(mechanism), out_(out), joints_(model, out) {
    result_.file = std::move(file);
  }

  std::optional<RestoredState> read(const Value& root) {
    const std::vector<std::string> known{"time",     "gravity", "mechanisms", "joints", "springs",     "couplings",
                                         "contacts", "bodies",  "armed",      "loops",  "integration", "totals"};
    const auto meant = [&known](const Value::Entry& entry) { return !nearest(entry.key, known).empty(); };
    const Value::Table* const table = root.table();
    if (!table || (!table->empty() && std::none_of(table->begin(), table->end(), meant))) {
      // any file may be named as a document: nothing of it is quoted
      out_.error(root.place, "this is not a state document", "it has none of `time`, `mechanisms`, `joints`, `bodies`");
      return {};
    }
    Fields fields(root, "the state document", out_, "");
    const Value* const mechanisms = fields.find("mechanisms");
    const bool whole = mechanisms != nullptr && mechanism_.empty();
    if (const Value* joints = fields.find("joints"))
      for (const Value::Entry& joint : read_table(*joints, "joints", out_)) whole ? describe(joint) : read_partial(joint);
    if (mechanism_.empty()) {
      result_.time = fields.real("time");
      if (result_.time && *result_.time < 0) out_.error(fields.place_of("time"), "time: must not be negative");
      result_.forest.gravity = fields.vec3("gravity", dimension::acceleration);
      if (const Value* springs = fields.find("springs"))
        for (const Value::Entry& spring : read_table(*springs, "springs", out_))
          read_spring_state(spring, model_, result_.forest, out_);
      if (const Value* couplings = fields.find("couplings")) read_coupling_states(*couplings, model_, result_.forest, out_);
      if (const Value* contacts = fields.find("contacts"))
        read_contacts(*contacts, model_, joints_, result_.forest, result_.memory.stepping, out_);
      if (const Value* bodies = fields.find("bodies"))
        for (const Value::Entry& body : read_table(*bodies, "bodies", out_)) joints_.body_named(body.key, body.place);
      if (const Value* armed = fields.find("armed"))
        for (const Value::Entry& event : read_table(*armed, "armed", out_)) read_armed(event);
      if (const Value* integration = fields.find("integration")) read_integration(*integration);
    }
    for (const std::string& key : known) fields.find(key);
    fields.finish();
    if (whole && out_.errors() == 0) read_forest(*mechanisms);
    if (out_.errors() > 0) return {};
    return std::move(result_);
  }

 private:
  const BodySpec& spec(BodyId body) const { return model_[body]; }

  bool in_mechanism(BodyId body) const {
    while (spec(body).parent != ground) body = spec(body).parent;
    return model_.mechanism_name(body) == mechanism_;
  }

  void add(const DescribedJoint& joint, JointId number) {
    result_.joints.push_back({number, joint.q, joint.v, joint.p});
    const Place place = joint.entry->place;
    result_.where.push_back(result_.file + ':' + std::to_string(place.line) + ':' + std::to_string(place.column));
  }

  /// For an incomplete document, or for one mechanism of a complete one: joints must be as in the model.
  void read_partial(const Value::Entry& entry) {
    const std::string& name = entry.key;
    if (!model_.has_joint(name)) {
      if (!mechanism_.empty() && !name.starts_with(mechanism_ + "/")) return;
      std::string hint = joints_.suggest(name, &BodySpec::joint_name);
      if (hint.empty() && model_.has_body(name))
        hint = "a body of that name exists: a joint that broke is restored by a complete document, with `mechanisms`";
      return out_.error(entry.place, "unknown joint " + in_quotes(name), hint);
    }
    const JointId number = model_.joint(name);
    if (is_loop(number)) return;  // its coordinates follow from those of the tree
    const BodyId child = model_.child(number);
    if (!mechanism_.empty() && !in_mechanism(child)) return;
    const auto joint = joints_.describe(entry, &spec(child), child);
    if (!joint) return;
    if (const char* key = JointReader::difference(*joint, spec(child), false))
      return out_.error(entry.value.find(key)->value.place,
                        std::string(key) + ": is not that of joint " + in_quotes(name) + " in the model", whole_document);
    add(*joint, number);
  }

  /// A joint or a mechanism that is not in the model gets its name from the document alone.
  void require_name(const std::string& name, Place place, const char* what) {
    if (name.empty() || name.size() > 500 || name.find_first_of(",\"*") != std::string::npos ||
        first_invisible(name) != std::string::npos)
      out_.error(place, std::string(what) + " cannot be named " + in_quotes(name),
                 "a name has no , \" * and no invisible characters");
  }

  void describe(const Value::Entry& entry) {
    const std::string& name = entry.key;
    require_name(name, entry.place, "a joint");
    const bool of_tree = model_.has_joint(name) && !is_loop(model_.joint(name));
    const BodyId declared = of_tree ? model_.child(model_.joint(name)) : ground;
    BodyId child = declared;
    if (const Value::Entry* given = entry.value.find("child")) {
      const auto body = read_string(given->value, "child", out_);
      child = body ? joints_.body_named(*body, given->value.place).value_or(ground) : ground;
      if (child == ground) return;  // reported
    }
    if (child == ground && entry.value.table())
      return out_.error(entry.place, "joint " + in_quotes(name) + ", which the model does not have, has no 'child'");
    auto joint = joints_.describe(entry, declared != ground && child == declared ? &spec(declared) : nullptr, child);
    if (!joint) return;
    for (const DeeperStop& stop : joint->deeper) result_.memory.deeper.emplace_back(name, stop);
    if (joint->loop)
      add_loop(*joint);
    else
      described_.push_back(std::move(*joint));
  }

  void add_loop(const DescribedJoint& joint) {
    Forest::LoopJoint loop;
    loop.name = joint.name();
    loop.loop.body = joint.child.index, loop.loop.to = joint.parent.index;
    loop.loop.joint = joint.joint, loop.loop.parameters = joint.parameters;
    const KindInfo& kind = info(joint.joint.kind);
    if (joint.joint.locked != 0) {
      if (joint.q.empty())
        return out_.error(joint.entry->place, "loop joint " + in_quotes(loop.name) + " is locked, and has no q");
      loop.loop.held = joint.q;
    }
    LoopSpec spec;
    spec.name = loop.name, spec.body = joint.child, spec.to = joint.parent, spec.joint = spec_of(joint.joint);
    if (spec.joint.kind == Kind::free) spec.joint.kind = Kind::weld;  // a loop joint may become free, not begin so
    spec.joint.parameters = joint.parameters;
    for (const BodyProblem& problem : check_loop(spec, model_.size()))
      out_.error(joint.entry->place, "loop joint " + in_quotes(loop.name) + ": " + problem.field + ": " + problem.what,
                 problem.hint);
    if (joint.q.size() == kind.nq) loop.turns = turns_of(joint.joint.kind, joint.q.begin());
    loop.active_limits = joint.active_limits;
    result_.forest.loops.push_back(std::move(loop));
  }

  void read_integration(const Value& value) {
    Fields fields(value, "integration", out_, "");
    if (const auto step = fields.real("step")) {
      result_.memory.next_step = *step;
      if (!(*step > 0)) out_.error(fields.place_of("step"), "step: must be greater than 0");
    }
    result_.memory.work = fields.real("work").value_or(result_.memory.work);
    if (const Value* contacts = fields.find("contacts")) read_stepping(*contacts, model_, joints_, result_.memory.stepping, out_);
    fields.finish();
  }

  EventStatus read_condition(Fields& fields) {
    EventStatus armed;
    armed.fired = fields.count("fired").value_or(0);
    armed.done = fields.boolean("done").value_or(false), armed.resting = fields.boolean("resting").value_or(false);
    armed.time = fields.real("due").value_or(std::numeric_limits<double>::infinity());
    armed.since = fields.real("since").value_or(armed.since);
    const Value* const looked = fields.find("looked");
    if (!looked) return armed;
    std::vector<std::vector<double>> looks;
    for (const Value& entry : read_list(*looked, "looked", out_)) looks.push_back(read_reals(entry, 2, "looked", out_));
    if (looks.empty() || looks.size() > 2)
      out_.error(looked->place, "looked: expected one or two entries [time, excess]");
    else if (looks.front().size() == 2 && looks.back().size() == 2) {
      armed.looked = looks.back()[0], armed.excess = looks.back()[1];
      if (looks.size() == 2) armed.looked_before = looks.front()[0], armed.excess_before = looks.front()[1];
    }
    return armed;
  }

  void read_armed(const Value::Entry& entry) {
    Fields fields(entry.value, "event " + in_quotes(entry.key), out_, "");
    if (!entry.value.table()) return;
    ArmedEvent event{entry.key, fields.count("fired").value_or(0)};
    if (const Value* each = fields.find("each")) {
      for (const Value& item : read_list(*each, "each", out_)) {
        Fields one(item, "an entry of each", out_, "");
        event.each.push_back(read_condition(one));
        one.finish();
      }
      for (const char* key : {"done", "due", "since", "resting", "looked"}) fields.find(key);
    } else if (entry.value.table()->size() > 1) {
      event.each.push_back(read_condition(fields));
    }
    fields.finish();
    result_.armed.push_back(std::move(event));
  }

  void read_forest(const Value& mechanisms) {
    const std::vector<int> numbers = number_joints();
    if (!attach_bodies(numbers, mechanisms)) return;
    for (std::size_t k = 0; k < described_.size(); ++k) take(described_[k], numbers[k]);
    std::sort(result_.forest.changed.begin(), result_.forest.changed.end(),
              [](const Forest::Changed& a, const Forest::Changed& b) { return a.joint < b.joint; });
    read_mechanisms(mechanisms);
  }

  /// A joint that connects the same bodies as the model's joint of that name gets its number, unless a change made it;
  /// the others get the remaining numbers in the order of the document, in which they were written.
  std::vector<int> number_joints() {
    std::vector<char> taken(model_.bodies().size(), 0);
    std::vector<int> numbers;
    for (const DescribedJoint& joint : described_) {
      const bool of_tree = model_.has_joint(joint.name()) && !is_loop(model_.joint(joint.name()));
      const BodyId same = of_tree ? model_.child(model_.joint(joint.name())) : ground;
      const bool as_declared = same != ground && same == joint.child && spec(same).parent == joint.parent;
      const bool ours = as_declared && !joint.made;
      numbers.push_back(ours ? same.index : -1);
      if (ours) taken[static_cast<std::size_t>(same.index)] = 1;
    }
    std::size_t next = 0;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (numbers[k] >= 0) continue;
      while (next < taken.size() && taken[next] != 0) ++next;
      if (next == taken.size()) {
        out_.error(described_[k].entry->place, "there are more joints than bodies", "each body has one joint");
        break;
      }
      numbers[k] = static_cast<int>(next++);
    }
    return numbers;
  }

  /// Determines the carrying body of each joint, and the parent of that body.
  bool attach_bodies(const std::vector<int>& numbers, const Value& mechanisms) {
    const std::size_t n = model_.bodies().size();
    std::vector<Topology::Place>& places = result_.forest.places;
    std::vector<const DescribedJoint*> joint_of(n, nullptr);
    places.resize(n);
    for (std::size_t k = 0; k < described_.size(); ++k) {
      const DescribedJoint& joint = described_[k];
      const BodyId carrier = joint.reversed ? joint.parent : joint.child, outer = joint.reversed ? joint.child : joint.parent;
      const auto b = static_cast<std::size_t>(carrier.index);
      if (joint_of[b] != nullptr)
        out_.error(joint.entry->place, "body " + in_quotes(spec(carrier).name) + " already has a joint, on " +
                                           out_.name_of(joint_of[b]->entry->place));
      joint_of[b] = &joint;
      places[b] = {outer.index, numbers[k], joint.reversed};
    }
    if (out_.errors() > 0) return false;
    for (std::size_t b = 0; b < n && !out_.full(); ++b)
      if (joint_of[b] == nullptr)
        out_.error(mechanisms.place, "the document has no joint for body " + in_quotes(model_.bodies()[b].name),
                   "leave `mechanisms` out if the document is not complete");
    if (out_.errors() > 0) return false;
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
        out_.error(joint_of[static_cast<std::size_t>(a)]->entry->place,
                   "the joints form a cycle at body " + in_quotes(spec({a}).name));
      for (const std::size_t passed : way) state[passed] = seen;
    }
    return out_.errors() == 0;
  }

  void take(const DescribedJoint& joint, int number) {
    const KindInfo& kind = info(joint.joint.kind);
    const auto lacks = [&](const char* what, const char* hint) {
      out_.error(joint.entry->place, "joint " + in_quotes(joint.name()) + what, hint);
    };
    if (kind.nq > 0 && joint.q.empty()) lacks(" has no 'q'", "a complete document gives it for every joint");
    if (kind.nv > 0 && joint.v.empty() && joint.p.empty())
      lacks(" has neither 'v' nor 'p'", "a complete document gives one of them for every joint");
    add(joint, {number});
    for (ActiveLimit hold : joint.active_limits) {
      hold.joint = number;
      result_.forest.active_limits.push_back(hold);
    }
    for (SteppedContact stop : joint.stepped) {
      stop.joint = number, stop.a = (joint.reversed ? joint.parent : joint.child).index;
      result_.memory.stepping.points.insert(result_.memory.stepping.points.begin(), stop);  // before contacts
    }
    const BodySpec& ours = spec({number});
    if (!joint.made && joint.name() == ours.joint_name && joint.child.index == number && joint.parent == ours.parent) {
      const char* const key = JointReader::difference(joint, ours, true);
      if (key == nullptr || key == std::string_view("reversed")) return;
    }
    Forest::Changed changed{number, joint.name(), joint.joint, joint.parameters};
    changed.as.created_by_event = joint.made;
    result_.forest.changed.push_back(std::move(changed));
  }

  /// Every body must be in one mechanism, together with the bodies that its joints lead to.
  void read_mechanisms(const Value& mechanisms) {
    const std::vector<Topology::Place>& places = result_.forest.places;
    struct Entry {
      std::string name;                 // empty: not given
      std::optional<std::string> root;  // its body
      Place place{}, root_place{};
      bool rooted = false;
    };
    std::vector<Entry> all;
    std::vector<int> mechanism_of(places.size(), -1);
    for (const Value& mechanism : read_list(mechanisms, "mechanisms", out_)) {
      Fields fields(mechanism, "a mechanism", out_, "");
      Entry& entry = all.emplace_back();
      entry.place = mechanism.place;
      entry.root = fields.string("root");
      entry.root_place = fields.place_of("root");
      if (const auto name = fields.string("name")) require_name(entry.name = *name, fields.place_of("name"), "a mechanism");
      if (const Value* bodies = fields.require("bodies"))
        for (const Value& value : read_list(*bodies, "bodies", out_)) {
          const auto name = read_string(value, "bodies", out_);
          const auto body = name ? joints_.body_named(*name, value.place) : std::nullopt;
          if (!body) continue;
          int& place = mechanism_of[static_cast<std::size_t>(body->index)];
          if (place >= 0) out_.error(value.place, "body " + in_quotes(*name) + " is in two mechanisms, or twice in one");
          place = static_cast<int>(all.size()) - 1;
        }
      fields.finish();
    }
    if (out_.errors() > 0) return;
    for (std::size_t b = 0; b < places.size() && !out_.full(); ++b) {
      const std::string& body = model_.bodies()[b].name;
      if (mechanism_of[b] < 0) {
        out_.error(mechanisms.place, "body " + in_quotes(body) + " is in no mechanism");
        continue;
      }
      Entry& entry = all[static_cast<std::size_t>(mechanism_of[b])];
      const int parent = places[b].parent;
      if (entry.root && (parent < 0) != (entry.root == body))
        out_.error(entry.root_place, "root: does not fit the joints", "see body " + in_quotes(body));
      if (parent >= 0 && mechanism_of[static_cast<std::size_t>(parent)] != mechanism_of[b])
        out_.error(entry.place, "body " + in_quotes(body) + " is in another mechanism than the parent of its joint");
      if (parent >= 0) continue;
      if (entry.rooted) out_.error(entry.place, "a mechanism has one root, but " + in_quotes(body) + " is a second one");
      entry.rooted = true;
      result_.forest.mechanisms.emplace_back(static_cast<int>(b), entry.name.empty() ? body : entry.name);
    }
  }

  const Model& model_;
  const std::string& mechanism_;
  Diagnostics& out_;
  JointReader joints_;
  std::vector<DescribedJoint> described_;
  RestoredState result_;
};

}  // namespace

std::optional<RestoredState> read_state(const std::string& text, const std::string& file, const Model& model,
                                        const std::string& mechanism, std::vector<Diagnostic>& problems) {
  Diagnostics out(file, "");
  std::optional<RestoredState> state = Reader(file, model, mechanism, out).read(parse_json(text, file));
  problems = out.take();
  return state;
}

RestoredState read_state(const std::string& text, const std::string& file, const Model& model, const std::string& mechanism) {
  std::vector<Diagnostic> problems;
  std::optional<RestoredState> state = read_state(text, file, model, mechanism, problems);
  if (!state) throw InputError(std::move(problems));
  return std::move(*state);
}

}  // namespace momentree::io
