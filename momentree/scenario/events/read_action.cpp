// One entry of an event's actions: a name, or a table with the fields that the action needs.
#include <algorithm>

#include <momentree/scenario/events/read_action.hpp>
#include <momentree/scenario/keys/joint_keys.hpp>

namespace momentree::io {

namespace {

struct ParametersProbe final : IgnoredFields {
  void parameters(const std::string&, JointParameters&) override { found = true; }
  bool found = false;
};

// The name in an entry that may contain a wildcard: that of the joint or body that it acts on.
const Value* wild_name(const Value& entry) {
  const Value* name = &entry;
  for (const char* key : {"joint", "body"})
    if (const Value::Entry* found = entry.find(key)) name = &found->value;
  return name->string() && name->string()->find('*') != std::string::npos ? name : nullptr;
}

void read_for(const KindInfo* kind, Fields& fields, JointParameters& parameters, Diagnostics& out) {
  const std::size_t errors = out.errors();
  read_parameters(fields, kind, parameters, out);
  if (!kind || errors != out.errors()) return;
  JointSpec spec;
  spec.kind = kind->kind, spec.axis2 = x_axis, spec.pitch = 1, spec.parameters = parameters;
  report_problems(spec, fields, out);
}

}  // namespace

std::string mechanism_of(const std::string& name) { return name.substr(0, name.find('/')); }

const std::vector<std::string>& scenario_actions() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> all = action_keys();
    std::erase_if(all, [](const std::string& key) { return !make_action(key)->in_scenarios(); });
    return all;
  }();
  return keys;
}

bool sets_parameters(ActionBase& action) {
  ParametersProbe probe;
  action.fields(probe);
  return probe.found;
}

ActionReader::ActionReader(const Value& value, ActionBase& action, const std::string& match, double time, Reading& reading)
    : value_(value),
      action_(action),
      key_(action.key()),
      plain_field_(action.plain_field()),
      sets_parameters_(sets_parameters(action)),
      match_(match),
      time_(time),
      reading_(reading),
      out_(reading.out) {
  if (value.table())
    fields_.emplace(value, key_, out_);
  else if (!plain_field_)
    out_.error(value.place, key_ + ": expected a table, found " + value.type_name(), action.hint());
}

bool ActionReader::read() {
  const std::size_t errors = out_.errors();
  if (!fields_ && !plain_field_) return false;
  action_.fields(*this);
  if (fields_) fields_->finish();
  if (errors == out_.errors() && !acts_) out_.error(value_.place, key_ + ": changes nothing", action_.hint());
  return errors == out_.errors();
}

const Value* ActionReader::given(const char* key, bool required) {
  if (fields_) return required ? fields_->require(key, action_.hint()) : fields_->find(key);
  return plain_field_ == std::string_view(key) ? &value_ : nullptr;
}

std::optional<std::string> ActionReader::name(const char* key, bool required, Place& place) {
  const Value* value = given(key, required);
  if (!value) return {};
  place = value->place;
  return read_string(*value, fields_ ? key : key_.c_str(), out_);
}

void ActionReader::joint(const char* key, std::string& name) {
  Place place;
  const auto text = this->name(key, true, place);
  if (!text) return;
  name = match_.empty() ? *text : match_;
  if (match_.empty()) reading_.joint_uses.push_back({name, key_, place, time_, sets_parameters_, action_.takes_springs()});
}

void ActionReader::made_joint(const char* key, std::string& name) {
  if (!fields_) return;
  const auto text = fields_->string(key);
  if (!text) return;
  const Place place = fields_->place_of(key);
  const std::string bare = text->substr(text->rfind('/') + 1);  // it may be in a mechanism: "tug/clasp"
  if (!check_bare_name(bare, place, "a joint", out_)) return;
  if (!match_.empty())
    return out_.error(place, key_ + ": joints that a wildcard makes can't all be named " + in_quotes(*text),
                      "leave out the name: each is then named after its bodies");
  name = *text;
}

void ActionReader::body(const char* key, std::string& name, bool ground_too) {
  Place place;
  const auto text = this->name(key, !ground_too, place);
  if (!text) return;
  const bool matched = !match_.empty() && !ground_too;
  name = matched ? match_ : *text;
  if (matched || (ground_too && name == "ground")) return;
  if (name == "ground") {
    out_.error(place, key_ + ": this action cannot be applied to the ground",
               value_.find("to") ? "the ground can only be the body that another is joined 'to'" : "");
  } else if (name.find('*') != std::string::npos) {
    out_.error(place, key_ + ": '" + key + "' is one body: " + in_quotes(name) + " can match several");
  } else if (!reading_.bodies.contains(name) && !reading_.opaque.contains(mechanism_of(name))) {
    const auto joint = reading_.joints.find(name);
    std::string hint = joint != reading_.joints.end() ? "that is the name of a joint" : "";
    if (hint.empty() && name.find('/') == std::string::npos)
      for (const auto& [mechanism, where] : reading_.mechanisms)
        if (reading_.bodies.contains(mechanism + "/" + name)) hint = "use the full name: " + in_quotes(mechanism + "/" + name);
    if (hint.empty()) hint = reading_.suggest(name, reading_.bodies);
    if (hint.empty() && means_ground(name)) hint = "the ground is \"ground\"";
    out_.error(place, key_ + ": there is no body " + in_quotes(name), std::move(hint));
  }
}

void ActionReader::dofs(const char* key, const std::string&, std::vector<int>& numbers) {
  if (!fields_) return;
  const Value* list = fields_->find(key);
  if (!list) return;
  if (!list->array()) return out_.error(list->place, std::string(key) + ": expected a list, found " + list->type_name(), hint_);
  if (list->array()->empty())
    out_.error(list->place, std::string(key) + ": names no degree of freedom", "leave it out for all of them");
  unsigned seen = 0;
  for (const Value& entry : *list->array()) {
    const std::int64_t* number = entry.integer();
    if (!number || *number < 0 || *number > 5) {
      out_.error(entry.place,
                 std::string(key) + ": expected a number from 0 to 5" +
                     (number ? ", not " + std::to_string(*number) : std::string(", found ") + entry.type_name()),
                 hint_);
    } else if ((seen >> *number & 1u) != 0) {
      out_.error(entry.place, std::string(key) + ": " + std::to_string(*number) + " is given twice");
    } else {
      seen |= 1u << *number;
      numbers.push_back(static_cast<int>(*number));
    }
  }
}

void ActionReader::vector(const char* key, Vec3& value, const Dimension& dimension, const char*) {
  if (!fields_) return;
  const bool wrench = !(dimension == dimension::length);
  if (wrench && !asked_) asked_ = true, acts_ = false;
  if (wrench && fields_->has(key)) acts_ = true;
  value = fields_->vec3(key, dimension).value_or(value);
}

void ActionReader::placement(const char* key, std::optional<Pose>& value, const char*) {
  if (fields_) value = fields_->pose(key);
}

void ActionReader::description(JointDescription& joint, bool keeps_axes) {
  if (!fields_) return;
  read_description(*fields_, keeps_axes, joint, out_);
}

void ActionReader::parameters(const std::string& of, JointParameters& parameters) {
  if (!fields_) return;
  acts_ = false;
  for (const JointKey& key : joint_keys()) acts_ = acts_ || (!key.documents && fields_->has(key.key));
  const std::vector<const KindInfo*> kinds = kinds_of ? kinds_of(of) : std::vector<const KindInfo*>();
  const KindInfo* kind = kinds.empty() ? nullptr : kinds.front();
  if (kinds.size() > 1) {
    const auto fitting = std::find_if(kinds.begin(), kinds.end(), [&](const KindInfo* each) { return fits(*each); });
    if (fitting != kinds.end()) kind = *fitting;
  }
  const std::size_t errors = out_.errors();
  if (!kind && errors > 0) {  // it may be one of the joints that could not be read
    for (const JointKey& key : joint_keys()) static_cast<void>(fields_->find(key.key));
    return;
  }
  read_for(kind, *fields_, parameters, out_);
}

// True if the parameters are possible for joints of that kind.
bool ActionReader::fits(const KindInfo& kind) const {
  Diagnostics problems("", "");
  Fields fields(value_, key_, problems);
  JointParameters parameters;
  read_for(&kind, fields, parameters, problems);
  return problems.errors() == 0;
}

void read_actions(const Value& value, const std::string& key, ScenarioEvent& event, const TriggerMatch* trigger,
                  std::vector<ScenarioEvent>& wild, Reading& reading) {
  Diagnostics& out = reading.out;
  const Value::Array single = value.array() ? Value::Array{} : Value::Array{value};
  const Value::Array& entries = value.array() ? *value.array() : single;
  const std::shared_ptr<ActionBase> any = make_action(key);
  const bool late = sets_parameters(*any);
  const std::string plain = any->plain_field() ? any->plain_field() : "";
  if (entries.empty()) out.error(value.place, key + (plain.empty() ? ": an empty list does nothing" : ": names no " + plain));
  // At a known instant each match becomes a separate event; otherwise all matches happen together with the event.
  const bool together = trigger != nullptr || event.condition || !event.after.empty() || event.period > 0;
  const auto add = [&](const Value& entry, const std::string& match, ScenarioEvent& to) {
    if (--reading.actions_left < 0) {
      if (reading.actions_left == -1)
        out.error(entry.place, "more than 1000000 actions", "a wildcard counts once for each name that it matches");
      return false;
    }
    const std::shared_ptr<ActionBase> action = make_action(key);
    if (late)  // the units depend on a joint that another event may make
      reading.late.push_back({action, value.array() ? &entry : &value, match, event.time});
    else if (!ActionReader(entry, *action, match, event.time, reading).read())
      return false;
    to.actions.emplace_back(std::shared_ptr<const ActionBase>(action));
    to.places.push_back(entry.place);
    return true;
  };
  for (const Value& entry : entries) {
    const Value* pattern = wild_name(entry);
    if (!pattern) {
      add(entry, "", event);
      continue;
    }
    const bool bodies = entry.table() ? entry.find("body") != nullptr : plain == "body";
    const std::string& name = *pattern->string();
    if (trigger && name == trigger->pattern) {
      add(entry, bodies ? trigger->body : trigger->joint, event);
      continue;
    }
    const std::vector<std::string> found =
        bodies ? matching_bodies(name, reading) : matching_joints(name, any->takes_springs(), reading);
    if (found.empty() && !reading.opaque.contains(mechanism_of(name)))
      out.error(pattern->place, key + ": no " + (bodies ? "body" : "joint") + " matches " + in_quotes(name),
                "* matches within a name: \"chain/*\"");
    for (const std::string& match : found) {
      if (together) {
        event.wild = true;
        if (!add(entry, match, event)) break;
        continue;
      }
      ScenarioEvent each;
      each.name = event.name, each.wild = true, each.time = event.time, each.place = event.place;
      if (!add(entry, match, each)) break;
      wild.push_back(std::move(each));
    }
  }
}

}  // namespace momentree::io
