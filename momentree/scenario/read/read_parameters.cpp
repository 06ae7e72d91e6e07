// Parameters of a joint, by the keys of joint_keys.hpp: from a scenario, with the units of the joint's kind or, if the kind is
// unknown (a joint that an event makes), as numbers in SI units; from a state document as plain numbers.
#include <algorithm>
#include <cmath>

#include <momentree/scenario/keys/dof_values.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/scenario/state/parameters_json.hpp>

namespace momentree::io {

namespace {

class ParameterFields {
 public:
  /// `kind`: null if it is unknown. `document`: a state document, whose values check_joint() judges.
  ParameterFields(const KindInfo* kind, bool document, Diagnostics& out) : kind_(kind), document_(document), out_(out) {}

  JointParameters read(Fields& fields) {
    read(fields, joint_keys());
    return settings_.packed();
  }

 private:
  void read(Fields& fields, std::span<const JointKey> keys) {
    for (const JointKey& key : keys) {
      if (key.documents && !document_) continue;
      const Value* value = key.required && !document_ ? fields.require(key.key, key.required) : fields.find(key.key);
      if (value) std::visit([&](const auto& target) { read(*value, key, target); }, key.value);
    }
  }

  void read(const Value& value, const JointKey& key, JointKey::PerDof target) {
    const Values numbers = values(value, key);
    if (kind_ && kind_->nv == 0 && numbers.any())
      out_.error(value.place, std::string(key.key) + ": " + a_joint() + " does not move",
                 "leave it out; a weld has at most a strength");
    else if (std::all_of(numbers.begin(), numbers.end(), [&](double x) { return in_range(x, key, value.place); }))
      target(settings_) = numbers;
  }

  void read(const Value& value, const JointKey& key, JointKey::Number target) {
    std::optional<double> number;
    if (document_ || key.quantity == Quantity::force || key.quantity == Quantity::torque) {
      number = plain_number(value, key);
    } else if (const Values one = values(value, key); one.size() > 1) {
      out_.error(value.place, std::string(key.key) + ": expected one number");
    } else if (!one.empty()) {
      number = one[0];
    }
    if (number && in_range(*number, key, value.place)) target(settings_) = *number;
  }

  void read(const Value& value, const JointKey& key, JointKey::Signals target) {
    if (key.one_dof && kind_ && (kind_->nq != 1 || kind_->nv != 1))
      return out_.error(value.place,
                        std::string(key.key) + ": " + a_joint() + " has " + std::to_string(kind_->nv) +
                            (kind_->nv == 1 ? " degree of freedom" : " degrees of freedom") + ": a " + key.key +
                            " is for joints with one degree of freedom",
                        "use pd with a stiff kp, one target per degree of freedom");
    std::vector<Signal> all = signals(value, key);
    if (key.one_dof && all.size() > 1) return out_.error(value.place, std::string(key.key) + ": expected one value");
    target(settings_) = std::move(all);
  }

  void read(const Value& value, const JointKey& key, const JointGroup& group) {
    const std::size_t errors = out_.errors();
    Fields fields(value, key.key, out_, document_ ? "" : nullptr);
    if (group.rates && kind_ && (kind_->nq != kind_->nv || kind_->nv == 0))
      return out_.error(value.place, std::string(key.key) + ": " + a_joint() + " has no coordinates that could " + group.rates);
    if (!value.table()) return;
    read(fields, group.keys);
    if (!document_) {
      if (group.either[0] && !fields.has(group.either[0]) && !fields.has(group.either[1]))
        out_.error(value.place, std::string(key.key) + ": " + group.missing, group.hint);
      if (key.key == std::string_view("limits")) check_limits(fields);
      if (key.key == std::string_view("drive")) check_drive(value, fields);
    }
    fields.finish();
    if (errors == out_.errors()) return;
    JointSettings none;  // what was wrong is not checked again
    const auto reset = [](auto& to, const auto& from) { return to = from, true; };
    alike(group.keys, settings_, none, reset);
  }

  // A stop is hard or soft.
  void check_limits(const Fields& fields) {
    if (fields.has("damping") && !fields.has("stiffness"))
      out_.error(fields.place_of("damping"), "limits: 'damping' goes with 'stiffness'",
                 "a hard stop dissipates energy by 'restitution'");
    for (const char* key : {"restitution", "rest_speed"})
      if (fields.has(key) && fields.has("stiffness"))
        out_.error(fields.place_of(key), "limits: a stop with 'stiffness' is soft and has no '" + std::string(key) + "'",
                   "leave out one of the two");
  }

  // An effort that is constant is a parameter of its own.
  void check_drive(const Value& value, const Fields& fields) {
    if (value.table()->empty())
      out_.error(value.place, "drive: drives nothing", "one of effort, pd and motion; effort = 0 removes a drive");
    for (const char* key : {"effort", "pd"})
      if (fields.has(key) && !settings_.motion.empty())
        out_.error(fields.place_of(key), std::string(key) + ": a joint whose motion is prescribed takes the effort that it needs",
                   "leave out '" + std::string(key) + "' or 'motion'");
    std::vector<Signal>& effort = settings_.drive.effort;
    if (!std::all_of(effort.begin(), effort.end(), [](const Signal& s) { return s.constant(); })) return;
    for (const Signal& s : effort) settings_.parameters.effort.push_back(s.value(0));
    effort.clear();
  }

  bool in_range(double x, const JointKey& key, Place place) {
    if (document_ || key.by_model) return true;
    const bool positive = key.range == Range::positive;
    if (positive ? x > 0 : key.range == Range::any || x >= 0) return true;
    out_.error(place, std::string(key.key) + (positive ? ": must be greater than 0" : ": must not be negative"), key.hint);
    return false;
  }

  // One signal for one DoF, else a list with one per DoF.
  std::vector<Signal> signals(const Value& value, const JointKey& key) {
    const std::string label = key.key;
    const Value::Array one{value};
    const Value::Array& entries = value.array() ? *value.array() : one;
    const std::size_t expected = kind_ ? letters(key).size() : entries.size();
    if (entries.size() != expected || entries.empty() || entries.size() > Values::capacity) {
      if (kind_ && kind_->nv == 0)
        out_.error(value.place, label + ": " + a_joint() + " has no degree of freedom to drive");
      else if (!value.array())
        out_.error(value.place,
                   label + ": " + a_joint() + " has " + std::to_string(expected) + " degrees of freedom: one " +
                       (key.quantity == Quantity::effort ? "number" : "value") + " is ambiguous",
                   "give a list, one " + label + " per degree of freedom");
      else
        out_.error(value.place,
                   label + ": expected " + std::to_string(expected) + (expected == 1 ? " value" : " values") +
                       ", found a list of " + std::to_string(entries.size()),
                   "one per degree of freedom or coordinate, in the order of the joint kind");
      return {};
    }
    std::vector<Signal> all;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Dimension dimension = kind_ ? dimension_of(key.quantity, letters(key)[i]) : dimension::number;
      const auto signal = read_signal(entries[i], {dimension, key.one_dof, document_}, label, out_);
      if (!signal) return {};
      all.push_back(*signal);
    }
    return all;
  }

  // One number for all DoFs, or a list.
  Values values(const Value& value, const JointKey& key) {
    if (kind_) return read_values(value, key.quantity, letters(key), !key.each, key.key, out_, key.infinite != 0);
    const Value::Array one{value};
    const Value::Array& entries = value.array() ? *value.array() : one;
    if (entries.empty() || entries.size() > Values::capacity) {
      out_.error(value.place, std::string(key.key) + ": expected 1 to " + std::to_string(Values::capacity) + " numbers");
      return {};
    }
    Values all;
    for (const Value& entry : entries) {
      const auto number = plain_number(entry, key);
      if (!number) return {};
      all.push_back(*number);
    }
    return all;
  }

  // A number whose dimension does not depend on the kind, or that is in SI units.
  std::optional<double> plain_number(const Value& value, const JointKey& key) {
    if (document_ && key.infinite != 0 && value.is_null()) return key.infinite;
    if (document_) return read_real(value, key.key, out_);
    const bool fixed = key.quantity == Quantity::force || key.quantity == Quantity::torque;
    return read_extended(value, fixed ? dimension_of(key.quantity, 'n') : dimension::number, key.infinite != 0, key.key, out_);
  }

  std::string_view letters(const JointKey& key) const { return key.quantity == Quantity::q ? kind_->q_units : kind_->v_units; }
  std::string a_joint() const { return "a " + std::string(kind_->name) + " joint"; }

  const KindInfo* kind_;
  const bool document_;
  Diagnostics& out_;
  JointSettings settings_;
};

}  // namespace

void read_parameters(Fields& fields, const KindInfo* kind, JointParameters& parameters, Diagnostics& out) {
  parameters = ParameterFields(kind, false, out).read(fields);
}

JointParameters parameters_of(const Value& value, Diagnostics& out) {
  Fields fields(value, "parameters", out, "");
  const JointParameters parameters = ParameterFields(nullptr, true, out).read(fields);
  fields.finish();
  return parameters;
}

}  // namespace momentree::io
