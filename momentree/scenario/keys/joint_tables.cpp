#include <momentree/scenario/keys/joint_tables.hpp>

#include <algorithm>
#include <limits>

#include <momentree/scenario/keys/joint_keys.hpp>

namespace momentree::io {

namespace {

// Copies the parameter `key` that a table gives into a joint's own parameters.
void take(JointParameters& own, const JointParameters& given, std::string_view key) {
  if (key == "drive") {  // shared by all joints of the table
    own.effort = given.effort, own.drive = given.drive;
    return;
  }
  const std::shared_ptr<const JointDrive> own_drive = std::move(own.drive);
  JointSettings to(own), from(given);
  for (const JointKey& each : joint_keys())
    if (each.key == key) alike({&each, 1}, to, from, [](auto& a, const auto& b) { return a = b, true; });
  own = to.parameters;
  own.drive = own_drive;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

}  // namespace

constinit const KeyTable joint_override_table{"override",
                                              "joint_override",
                                              "Values for joints of a model or a chain, in place of those that they have there",
                                              {},
                                              {},
                                              {&joint_starts},
                                              true};

JointTable::JointTable(Fields& fields, Place place, bool starts, std::string pattern, std::string where)
    : pattern_(std::move(pattern)), where_(std::move(where)), place_(place), starts_(starts) {
  for (const Key& key : joint_starts)
    if (const Value* value = starts ? fields.find(key.name) : nullptr) entries_.emplace_back(key.name, value);
  for (const JointKey& key : joint_keys())
    if (const Value* value = key.documents ? nullptr : fields.find(key.key)) entries_.emplace_back(key.key, value);
}

const Value* JointTable::value_of(std::string_view key) const {
  for (const auto& [each, value] : entries_)
    if (each == key) return value;
  return nullptr;
}

Place JointTable::place_of(std::string_view key) const {
  const Value* value = value_of(key);
  return value ? value->place : place_;
}

const JointTable::Part* JointTable::part(Kind kind) const {
  const auto found = parts_.find(kind);
  return found == parts_.end() || found->second.entries.empty() ? nullptr : &found->second;
}

JointTable::Part JointTable::read_part(const KindInfo& kind, const Entries& entries, Diagnostics& out) const {
  Value::Table table;
  for (const auto& [key, value] : entries) table.push_back({key, value->place, *value});
  const Value whole(std::move(table), place_);
  Fields fields(whole, where_, out);
  Part part;
  part.entries = entries;
  if (starts_) read_start(fields, kind, part.q, part.v, out);
  read_parameters(fields, &kind, part.parameters, out);
  return part;
}

// A weld has no DoF, but it can have a strength.
bool JointTable::can_have(const KindInfo& kind, const char* key, const Value* value) const {
  if (kind.nv == 0 && key != std::string_view("strength")) return false;
  Diagnostics unheard("", "");
  const Part part = read_part(kind, {{key, value}}, unheard);
  JointSpec joint;
  joint.kind = kind.kind, joint.axis2 = x_axis, joint.pitch = 1;
  take(joint.parameters, part.parameters, key);
  if (unheard.errors() > 0) return false;
  for (const JointProblem& problem : check_joint(joint))
    // a wrong number of values; all other errors are the same for every kind
    if (problem.what.find("freedom") != std::string::npos) return false;
  return true;
}

void JointTable::read(const std::vector<Kind>& kinds, Diagnostics& out) {
  if (wild()) return read_wild(kinds, out);
  for (const Kind kind : kinds) parts_.emplace(kind, read_part(info(kind), entries_, out));
}

void JointTable::read_wild(const std::vector<Kind>& kinds, Diagnostics& out) {
  std::map<Kind, Entries> entries;
  for (const auto& entry : entries_) {
    const auto& [key, value] = entry;
    std::vector<std::string> without;
    const KindInfo* moving = nullptr;
    bool any = false;
    for (const Kind kind : kinds) {
      if (can_have(info(kind), key, value)) {
        entries[kind].push_back(entry);
        any = true;
      } else if (info(kind).nv > 0) {
        without.push_back("'" + std::string(info(kind).name) + "'");
        if (!moving) moving = &info(kind);
      }
    }
    if (!any && !moving)
      out.error(value->place,
                std::string(key) + ": all joints that match " + in_quotes(pattern_) + " are welds, which do not move");
    else if (!any)  // the error for one of these kinds
      read_part(*moving, {entry}, out);
    else if (!without.empty())
      out.note(value->place, std::string(key) + ": joints that match " + in_quotes(pattern_) + " and are of kind " +
                                 joined(without) + " cannot have it, and do not get it");
  }
  for (auto& [kind, taken] : entries) parts_.emplace(kind, read_part(info(kind), taken, out));
}

void JointTable::check(Diagnostics& out) const {
  for (const auto& [kind, part] : parts_) {
    JointSpec joint;
    joint.kind = kind, joint.axis2 = x_axis, joint.pitch = 1, joint.parameters = part.parameters;
    for (const JointProblem& problem : check_joint(joint))
      out.error(place_of(problem.field), problem.field + ": " + problem.what, problem.hint);
  }
}

JointTables::JointTables(const Value* value, const char* of, Reading& reading) : reading_(reading), of_(of) {
  if (!value) return;
  const char* const example = "write [mechanism.joint.elbow], or [mechanism.joint.\"*\"] for all";
  if (!value->table()) {
    reading.out.error(value->place, std::string("joint: expected tables by the names of joints, found ") + value->type_name(),
                      example);
    return;
  }
  for (const Value::Entry& entry : *value->table()) {
    if (!entry.value.table()) {
      reading.out.error(entry.place,
                        "joint: expected a table under " + in_quotes(entry.key) + ", found " + entry.value.type_name(),
                        "these are names of joints: write [mechanism.joint.elbow] with " + in_quotes("damping = 0.1"));
      continue;
    }
    const std::string where = "[mechanism.joint." + entry.key.substr(0, 60) + "]";
    Fields fields(entry.value, joint_override_table, reading.out, where);
    const std::size_t errors = reading.out.errors();
    tables_.emplace_back(fields, entry.place, true, entry.key, where);
    fields.finish();
    if (entry.value.table()->empty() && errors == reading.out.errors())
      reading.out.warning(entry.place, where + " is empty", "give the joint a parameter, such as damping = 0.1");
    if (tables_.back().wild())
      wild_.push_back(tables_.size() - 1);
    else
      exact_.emplace(entry.key, tables_.size() - 1);
  }
}

template <class Visit>
void JointTables::each_for(const std::string& joint, Visit visit) const {
  for (const std::size_t w : wild_)
    if (matches_wildcard(tables_[w].pattern(), joint)) visit(tables_[w]);
  if (const auto exact = exact_.find(joint); exact != exact_.end()) visit(tables_[exact->second]);
}

void JointTables::read(const std::vector<std::pair<std::string, Kind>>& joints,
                       const std::unordered_map<std::string, std::string>& bodies) {
  if (!any()) return;
  std::unordered_map<std::string, Kind> kinds;
  std::unordered_map<std::string, Place> names;
  for (const auto& [name, kind] : joints) kinds.emplace(name, kind), names.emplace(name, Place{});
  for (JointTable& table : tables_) {
    std::vector<Kind> matched;
    if (!table.wild()) {
      if (const auto found = kinds.find(table.pattern()); found != kinds.end()) matched.push_back(found->second);
    } else {
      for (const auto& [name, kind] : joints)
        if (std::find(matched.begin(), matched.end(), kind) == matched.end() && matches_wildcard(table.pattern(), name))
          matched.push_back(kind);
    }
    if (!matched.empty()) {
      table.read(matched, reading_.out);
      continue;
    }
    std::string hint = "* matches within a name, written without its mechanism";
    if (!table.wild()) {
      const auto body = bodies.find(table.pattern());
      hint = body != bodies.end() ? "the joint of that body is " + in_quotes(body->second)
                                  : reading_.suggest(table.pattern(), names);
      const std::string_view tail = std::string_view(table.pattern()).substr(table.pattern().find('/') + 1);
      if (hint.empty() && of_ == std::string_view("chain")) hint = "the joints are 1 to " + std::to_string(joints.size());
      if (kinds.contains(std::string(tail))) hint = "leave out the mechanism's name here: " + in_quotes(tail);
    }
    reading_.out.error(table.place(),
                       table.wild() ? "joint: no joint of this " + std::string(of_) + " matches " + in_quotes(table.pattern())
                                    : "joint: there is no joint " + in_quotes(table.pattern()) + " in this " + of_,
                       std::move(hint));
  }
}

std::optional<Place> JointTables::start_of(const std::string& joint) const {
  const auto exact = exact_.find(joint);
  if (exact == exact_.end()) return {};
  for (const Key& key : joint_starts)
    if (tables_[exact->second].has(key.name)) return tables_[exact->second].place_of(key.name);
  return {};
}

bool JointTables::gives_position(const std::string& joint, Kind kind) const {
  bool given = false;
  each_for(joint, [&](const JointTable& table) {
    const JointTable::Part* part = table.part(kind);
    given = given || (part != nullptr && !part->q.empty());
  });
  return given;
}

std::unordered_map<std::string_view, Place> JointTables::places_for(const std::string& joint, Kind kind) const {
  std::unordered_map<std::string_view, Place> places;
  each_for(joint, [&](const JointTable& table) {
    if (const JointTable::Part* part = table.part(kind))
      for (const auto& [key, value] : part->entries) {
        const std::string_view k(key);
        places.insert_or_assign(k == "angle" || k == "position" ? "q" : k == "speed" ? "v" : k, value->place);
      }
  });
  return places;
}

void JointTables::apply(const std::string& joint, BodySpec& spec) const {
  if (!any()) return;
  each_for(joint, [&](const JointTable& table) {
    const JointTable::Part* part = table.part(spec.joint.kind);
    if (!part) return;
    for (const auto& [key, value] : part->entries) take(spec.joint.parameters, part->parameters, key);
    if (!part->q.empty()) spec.q = part->q;
    if (!part->v.empty()) spec.v = part->v;
  });
  if (!spec.joint.parameters.drive || !spec.joint.parameters.drive->moves()) return;
  const auto places = places_for(joint, spec.joint.kind);
  const auto place_of = [&places](const char* key) {
    const auto found = places.find(key);
    return found == places.end() ? std::nullopt : std::optional(found->second);
  };
  start_motion(spec, place_of("q"), place_of("v"), reading_.out);
}

void JointTables::apply(const std::string& joint, LoopSpec& loop) {
  if (!any()) return;
  constexpr int any_bodies = std::numeric_limits<int>::max();
  const auto problem_with = [](std::string_view key, const auto& problems) {
    const auto found = std::find_if(problems.begin(), problems.end(), [key](const auto& each) { return each.field == key; });
    return found == problems.end() ? std::pair<std::string, std::string>() : std::pair(found->what, found->hint);
  };
  each_for(joint, [&](const JointTable& table) {
    const JointTable::Part* part = table.part(loop.joint.kind);
    if (!part) return;
    for (const auto& [name, value] : part->entries) {
      const std::string_view key(name);
      const bool start =
          std::any_of(joint_starts.begin(), joint_starts.end(), [key](const Key& each) { return key == each.name; });
      LoopSpec tried = loop;
      take(tried.joint.parameters, part->parameters, key);
      auto [what, hint] = problem_with(key, check_loop(tried, any_bodies));
      if (!start && what.empty()) {
        loop.joint = std::move(tried.joint);
      } else if (table.wild() && problem_with(key, check_joint(tried.joint)).first.empty()) {
        if (left_out_.insert(value).second)
          reading_.out.note(value->place, std::string(key) + ": joint " + in_quotes(joint) + " closes a loop and cannot have it");
      } else if (start) {
        reading_.out.error(value->place, std::string(key) + ": joint " + in_quotes(joint) + " " + no_loop_start,
                           no_loop_start_hint);
      } else if (sound_) {
        reading_.out.error(value->place, "joint " + in_quotes(joint) + ": " + std::string(key) + ": " + what, hint);
        sound_ = false;
      }
    }
  });
}

void JointTables::check(const std::string& joint, const BodySpec& spec) {
  if (!any() || !sound_) return;
  const auto places = places_for(joint, spec.joint.kind);
  if (places.empty()) return;
  Diagnostics& out = reading_.out;
  for (const BodyProblem& problem : check_body(spec)) {
    const auto given = places.find(problem.field);
    const bool beyond = problem.field == "q" && problem.what.starts_with("starts beyond") && places.contains("limits");
    if (given == places.end() && !beyond) continue;  // values from the model are checked there
    const Place place = given == places.end() ? places.at("limits") : given->second;
    out.error(place, "joint " + in_quotes(joint) + ": " + problem.field + ": " + problem.what, problem.hint);
    sound_ = false;
  }
  if (const auto rest = places.find("rest"); rest != places.end() && spec.joint.parameters.stiffness.empty())
    out.warning(rest->second, "'rest' without 'stiffness' has no effect");
}

void check_start(const JointTables& tables, const std::string& joint, const Value& state, Diagnostics& out) {
  if (const std::optional<Place> first = tables.start_of(joint))
    out.error(state.place,
              "state: joint " + in_quotes(joint) + " has its start in [mechanism.joint." + joint.substr(0, 60) + "], on " +
                  out.name_of(*first),
              "give it in one of the two");
}

}  // namespace momentree::io
