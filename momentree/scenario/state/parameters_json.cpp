#include <momentree/scenario/state/parameters_json.hpp>

#include <momentree/scenario/keys/joint_keys.hpp>

namespace momentree::io {

namespace {

void write_signal(JsonWriter& json, const Signal& signal) {
  const SignalParts parts(signal);
  const auto write_numbers = [&](std::span<const SignalKey> keys) {
    for (const SignalKey& key : keys) json.member(key.key, parts.*key.number);
  };
  if (parts.form == SignalParts::Form::number) return void(json.value(parts.offset));
  json.begin_object();
  if (parts.form == SignalParts::Form::table) {
    json.key("table").begin_array();
    for (const Signal::Knot& knot : parts.table) json.begin_array().value(knot.time).value(knot.value).end_array();
    json.end_array();
    if (parts.ends == Signal::Ends::free) json.member("ends", "free");
  } else if (parts.form == SignalParts::Form::ramp) {
    write_numbers(ramp_keys());
    if (parts.from_here) json.member("from_here", true);
  } else {
    json.key("sine").begin_object();
    write_numbers(sine_keys());
    json.end_object();
  }
  json.end_object();
}

class ParameterWriter {
 public:
  ParameterWriter(JsonWriter& json, const JointParameters& parameters) : json_(json), settings_(parameters) {}

  void write(std::span<const JointKey> keys) {
    json_.begin_object();
    for (const JointKey& key : keys) std::visit([&](const auto& value) { write(key, value); }, key.value);
    json_.end_object();
  }

 private:
  void write(const JointKey& key, JointKey::PerDof value) {
    const Values& values = value(settings_);
    if (values.size() == 1)
      json_.member(key.key, values[0]);
    else if (!values.empty())
      json_.member(key.key, std::span<const double>(values.begin(), values.end()));
  }
  void write(const JointKey& key, JointKey::Number value) { json_.member(key.key, value(settings_)); }
  void write(const JointKey& key, JointKey::Signals value) {
    const std::vector<Signal>& signals = value(settings_);
    if (signals.empty()) return;
    json_.key(key.key);
    if (key.one_dof) return write_signal(json_, signals.front());
    json_.begin_array();
    for (const Signal& signal : signals) write_signal(json_, signal);
    json_.end_array();
  }
  void write(const JointKey& key, const JointGroup& group) {
    if (alike(group.keys, settings_, none_, [](const auto& a, const auto& b) { return a == b; })) return;
    json_.key(key.key);
    write(group.keys);
  }

  JsonWriter& json_;
  JointSettings settings_, none_;
};

}  // namespace

void write_parameters(JsonWriter& json, const JointParameters& parameters) {
  ParameterWriter(json, parameters).write(joint_keys());
}

}  // namespace momentree::io
