// Parameters of a joint: damping, springs, drives, friction, stops, strength. If the kind is known, with its units; if it is
// not (a joint that an event makes), numbers in SI units.
#include <algorithm>
#include <cmath>

#include <momentree/io/dof_values.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

namespace {

class ParameterFields {
 public:
  /// `kind`: null if it is unknown.
  ParameterFields(const KindInfo* kind, Diagnostics& out) : kind_(kind), out_(out) {}

  void read(Fields& fields, JointParameters& p) {
    take(fields, "damping", Quantity::damping, p.damping);
    take(fields, "stiffness", Quantity::stiffness, p.stiffness);
    take(fields, "armature", Quantity::armature, p.armature);
    if (const Value* rest = fields.find("rest")) p.rest = values(*rest, Quantity::q, false, "rest");
    if (const Value* drive = fields.find("drive")) read_drive(*drive, p);
    if (const Value* limits = fields.find("limits")) read_limits(*limits, p.limits);
    if (const Value* friction = fields.find("friction")) read_friction(*friction, p.friction);
    if (const Value* strength = fields.find("strength")) read_strength(*strength, p.strength);
  }

 private:
  std::string_view letters(Quantity quantity) const { return quantity == Quantity::q ? kind_->q_units : kind_->v_units; }
  std::string a_joint() const { return "a " + std::string(kind_->name) + " joint"; }

  // One number for all DoFs, if `single`, or a list.
  Values values(const Value& value, Quantity quantity, bool single, const char* label) {
    if (kind_) return read_values(value, quantity, letters(quantity), single, label, out_);
    const Value::Array one{value};
    const Value::Array& entries = value.array() ? *value.array() : one;
    if (entries.empty() || entries.size() > Values::capacity) {
      out_.error(value.place, std::string(label) + ": expected 1 to " + std::to_string(Values::capacity) + " numbers");
      return {};
    }
    Values all;
    for (const Value& entry : entries) {
      const auto number = read_number(entry, dimension::number, label, out_);
      if (!number) return {};
      all.push_back(*number);
    }
    return all;
  }

  void take(Fields& fields, const char* key, Quantity quantity, Values& target) {
    const Value* value = fields.find(key);
    if (!value) return;
    target = values(*value, quantity, true, key);
    if (!kind_ || kind_->nv > 0 || !target.any()) return;
    out_.error(value->place, std::string(key) + ": " + a_joint() + " does not move",
               "leave it out; a weld has at most a strength");
    target = {};
  }

  // One signal for one DoF, else a list with one per DoF.
  std::vector<Signal> signals(const Value& value, Quantity quantity, const char* label, bool motion = false) {
    const Value::Array one{value};
    const Value::Array& entries = value.array() ? *value.array() : one;
    const std::size_t expected = kind_ ? letters(quantity).size() : entries.size();
    if (entries.size() != expected || entries.empty() || entries.size() > Values::capacity) {
      if (kind_ && kind_->nv == 0)
        out_.error(value.place, std::string(label) + ": " + a_joint() + " has no degree of freedom to drive");
      else if (!value.array())
        out_.error(value.place,
                   std::string(label) + ": " + a_joint() + " has " + std::to_string(expected) +
                       " degrees of freedom: one value is ambiguous",
                   "give a list, one " + std::string(label) + " per degree of freedom");
      else
        out_.error(value.place,
                   std::string(label) + ": expected " + std::to_string(expected) + (expected == 1 ? " value" : " values") +
                       ", found a list of " + std::to_string(entries.size()),
                   "one per degree of freedom or coordinate, in the order of the joint kind");
      return {};
    }
    std::vector<Signal> all;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto signal =
          read_signal(entries[i], kind_ ? dimension_of(quantity, letters(quantity)[i]) : dimension::number, label, motion, out_);
      if (!signal) return {};
      all.push_back(*signal);
    }
    return all;
  }

  void read_drive(const Value& value, JointParameters& p) {
    Fields fields(value, "drive", out_);
    if (!value.table()) return;
    JointDrive drive;
    if (const Value* effort = fields.find("effort")) {
      if (kind_ && kind_->nv > 1 && !effort->array()) {
        out_.error(effort->place,
                   "effort: " + a_joint() + " has " + std::to_string(kind_->nv) + " degrees of freedom: one number is ambiguous",
                   "give a list, one effort per degree of freedom");
      } else {
        drive.effort = signals(*effort, Quantity::effort, "effort");
        if (std::all_of(drive.effort.begin(), drive.effort.end(), [](const Signal& s) { return s.constant(); })) {
          for (const Signal& s : drive.effort) p.effort.push_back(s.value(0));
          drive.effort.clear();
        }
      }
    }
    if (const Value* pd = fields.find("pd")) read_pd(*pd, drive.pd);
    if (const Value* motion = fields.find("motion")) read_motion(*motion, fields, drive);
    if (value.table()->empty())
      out_.error(value.place, "drive: drives nothing", "one of effort, pd and motion; effort = 0 removes a drive");
    fields.finish();
    if (!(drive == JointDrive{})) p.drive = std::make_shared<const JointDrive>(std::move(drive));
  }

  void read_pd(const Value& value, JointDrive::Pd& pd) {
    Fields fields(value, "pd", out_);
    if (!value.table()) return;
    if (kind_ && (kind_->nq != kind_->nv || kind_->nv == 0)) {
      out_.error(value.place, "pd: " + a_joint() + " has no coordinates that could follow a target");
      return;
    }
    const std::size_t errors = out_.errors();
    take(fields, "kp", Quantity::stiffness, pd.kp);
    take(fields, "kd", Quantity::damping, pd.kd);
    if (const Value* target = fields.find("target")) pd.target = signals(*target, Quantity::q, "target");
    if (const Value* speed = fields.find("target_speed")) pd.target_speed = signals(*speed, Quantity::v, "target_speed");
    take(fields, "max_effort", Quantity::effort, pd.max_effort);
    not_negative(fields, "kp", pd.kp);
    not_negative(fields, "kd", pd.kd);
    for (const double x : pd.max_effort)
      if (!(x > 0)) {
        out_.error(fields.place_of("max_effort"), "max_effort: must be greater than 0", "leave it out if there is no bound");
        pd.max_effort = {};
        break;
      }
    if (!fields.has("kp") && !fields.has("kd")) {
      out_.error(value.place, "pd: has neither 'kp' nor 'kd'", "the effort is kp·(target − q) + kd·(target_speed − v)");
    }
    fields.finish();
    if (errors != out_.errors()) pd = {};  // errors were reported
  }

  void read_motion(const Value& value, Fields& drive_fields, JointDrive& drive) {
    if (kind_ && (kind_->nq != 1 || kind_->nv != 1)) {
      out_.error(value.place,
                 "motion: " + a_joint() + " has " + std::to_string(kind_->nv) +
                     (kind_->nv == 1 ? " degree of freedom" : " degrees of freedom") +
                     ": a motion is for joints with one degree of freedom",
                 "use pd with a stiff kp, one target per degree of freedom");
      return;
    }
    for (const char* key : {"effort", "pd"})
      if (drive_fields.has(key)) {
        out_.error(drive_fields.place_of(key),
                   std::string(key) + ": a joint whose motion is prescribed takes the effort that it needs",
                   "leave out '" + std::string(key) + "' or 'motion'");
        return;
      }
    const std::vector<Signal> read = signals(value, Quantity::q, "motion", true);
    if (read.size() == 1) drive.motion.emplace_back(read.front());
  }

  void read_friction(const Value& value, JointFriction& friction) {
    Fields fields(value, "friction", out_);
    if (!value.table()) return;
    fields.require("coulomb", "for example friction = { coulomb = \"2 N m\", speed = \"0.01 rad/s\" }");
    fields.require("speed", "the friction fades below it: use about a hundredth of the joint's usual speed");
    take(fields, "coulomb", Quantity::effort, friction.coulomb);
    take(fields, "speed", Quantity::v, friction.speed);
    not_negative(fields, "coulomb", friction.coulomb);
    for (const double x : friction.speed)
      if (!(x > 0)) {
        out_.error(fields.place_of("speed"), "speed: must be greater than 0",
                   "friction is smoothed over it: coulomb·tanh(v/speed)");
        friction.speed = {};
        break;
      }
    fields.finish();
    if (friction.coulomb.empty() || friction.speed.empty()) friction = {};  // errors were reported
  }

  void read_strength(const Value& value, JointStrength& strength) {
    Fields fields(value, "strength", out_);
    if (!value.table()) return;
    if (!fields.has("force") && !fields.has("torque"))
      out_.error(value.place, "strength: neither 'force' nor 'torque'", "for example strength = { force = \"4 kN\" }");
    const auto side = [&](const char* key, const Dimension& expected, double& target) {
      const Value* given = fields.find(key);
      if (!given) return;
      if (const double* x = given->real(); x && std::isinf(*x) && *x > 0) return;
      const auto number = read_number(*given, expected, key, out_);
      if (!number) return;
      if (*number > 0)
        target = *number;
      else
        out_.error(given->place, std::string(key) + ": must be greater than 0",
                   "the load at which the joint breaks; leave it out if the joint bears any load");
    };
    side("force", dimension::force, strength.force);
    side("torque", dimension::torque, strength.torque);
    fields.finish();
  }

  void not_negative(Fields& fields, const char* key, Values& target) {
    for (const double x : target)
      if (x < 0) {
        out_.error(fields.place_of(key), std::string(key) + ": must not be negative");
        target = {};
        return;
      }
  }

  // One side of a joint's limits: like coordinates, but infinite if there is no stop.
  Values limit(const Value& value, const char* key) {
    const auto endless = [](const Value& entry) { return entry.real() && std::isinf(*entry.real()); };
    const Value::Array single{value};
    const Value::Array& entries = value.array() ? *value.array() : single;
    if (std::none_of(entries.begin(), entries.end(), endless) || entries.size() > Values::capacity)
      return values(value, Quantity::q, true, key);
    Values all;
    if (kind_ && value.array() && entries.size() != letters(Quantity::q).size()) {
      values(value, Quantity::q, false, key);  // reports the required number
      return all;
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Dimension expected = kind_ ? dimension_of(Quantity::q, letters(Quantity::q)[i]) : dimension::number;
      const auto number = endless(entries[i]) ? std::optional(*entries[i].real()) : read_number(entries[i], expected, key, out_);
      if (!number) return {};
      all.push_back(*number);
    }
    return all;
  }

  void read_limits(const Value& value, JointLimits& limits) {
    Fields fields(value, "limits", out_);
    if (kind_ && (kind_->nq != kind_->nv || kind_->nv == 0)) {
      out_.error(value.place, "limits: " + a_joint() + " has no coordinates that could be limited");
      return;
    }
    if (const Value* lower = fields.find("lower")) limits.lower = limit(*lower, "lower");
    if (const Value* upper = fields.find("upper")) limits.upper = limit(*upper, "upper");
    if (!fields.has("lower") && !fields.has("upper") && value.table())
      out_.error(value.place, "limits: neither 'lower' nor 'upper'",
                 "for example limits = { lower = \"-90 deg\", upper = \"90 deg\" }");
    take(fields, "restitution", Quantity::none, limits.restitution);
    take(fields, "stiffness", Quantity::stiffness, limits.stiffness);
    take(fields, "damping", Quantity::damping, limits.damping);
    not_negative(fields, "damping", limits.damping);
    for (const double x : limits.stiffness)
      if (!(x > 0)) {
        out_.error(fields.place_of("stiffness"), "stiffness: must be greater than 0", "leave it out for a hard stop");
        limits.stiffness = {};
        break;
      }
    if (fields.has("damping") && !fields.has("stiffness")) {
      out_.error(fields.place_of("damping"), "limits: 'damping' goes with 'stiffness'",
                 "a hard stop dissipates energy by 'restitution'");
      limits.damping = {};
    }
    for (const char* key : {"restitution", "rest_speed"})
      if (fields.has(key) && fields.has("stiffness")) {
        out_.error(fields.place_of(key), "limits: a stop with 'stiffness' is soft and has no '" + std::string(key) + "'",
                   "leave out one of the two");
        limits.restitution = {};
      }
    if (const Value* speed = fields.find("rest_speed")) {
      const Values read = values(*speed, Quantity::v, true, "rest_speed");
      if (read.size() > 1)
        out_.error(speed->place, "rest_speed: expected one number");
      else if (!read.empty())
        limits.rest_speed = read[0];
    }
    fields.finish();
  }

  const KindInfo* kind_;
  Diagnostics& out_;
};

}  // namespace

void read_parameters(Fields& fields, const KindInfo& kind, JointParameters& parameters, Diagnostics& out) {
  ParameterFields(&kind, out).read(fields, parameters);
}

void read_plain_parameters(Fields& fields, JointParameters& parameters, Diagnostics& out) {
  ParameterFields(nullptr, out).read(fields, parameters);
}

}  // namespace momentree::io
