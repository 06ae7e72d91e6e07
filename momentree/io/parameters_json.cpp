#include <momentree/io/parameters_json.hpp>

#include <cmath>
#include <limits>

namespace momentree::io {

namespace {

using Type = JsonNode::Type;
constexpr double infinity = std::numeric_limits<double>::infinity();

void write_values(JsonWriter& json, const char* key, const Values& values) {
  if (values.empty()) return;
  json.key(key);
  if (values.size() == 1)
    json.value(values[0]);
  else
    json.value(std::span<const double>(values.begin(), values.end()));
}

void write_signal(JsonWriter& json, const Signal& signal) {
  if (!signal.knots().empty()) {
    json.begin_object().key("table").begin_array();
    for (const Signal::Knot& knot : signal.knots()) json.begin_array().value(knot.time).value(knot.value).end_array();
    json.end_array();
    if (signal.ends() == Signal::Ends::free) json.member("ends", "free");
    json.end_object();
  } else if (signal.ramp_rate() != 0 || signal.from_here()) {
    json.begin_object().member("rate", signal.ramp_rate()).member("offset", signal.offset());
    if (signal.from_here()) json.member("from_here", true);
    json.end_object();
  } else if (signal == Signal(signal.offset())) {
    json.value(signal.offset());
  } else {
    json.begin_object().key("sine").begin_object();
    json.member("amplitude", signal.amplitude()).member("frequency", signal.frequency());
    json.member("phase", signal.phase()).member("offset", signal.offset());
    json.end_object().end_object();
  }
}

void write_signals(JsonWriter& json, const char* key, const std::vector<Signal>& signals) {
  if (signals.empty()) return;
  json.key(key).begin_array();
  for (const Signal& signal : signals) write_signal(json, signal);
  json.end_array();
}

// JSON numbers are finite: null represents infinity.
void write_limits(JsonWriter& json, const JointLimits& limits) {
  json.key("limits").begin_object();
  write_values(json, "lower", limits.lower);
  write_values(json, "upper", limits.upper);
  write_values(json, "restitution", limits.restitution);
  write_values(json, "stiffness", limits.stiffness);
  write_values(json, "damping", limits.damping);
  json.member("rest_speed", limits.rest_speed).end_object();
}

void write_drive(JsonWriter& json, const JointDrive& drive) {
  json.key("drive").begin_object();
  write_signals(json, "effort", drive.effort);
  if (!(drive.pd == JointDrive::Pd{})) {
    json.key("pd").begin_object();
    write_values(json, "kp", drive.pd.kp);
    write_values(json, "kd", drive.pd.kd);
    write_signals(json, "target", drive.pd.target);
    write_signals(json, "target_speed", drive.pd.target_speed);
    write_values(json, "max_effort", drive.pd.max_effort);
    json.end_object();
  }
  if (drive.moves()) {
    json.key("motion");
    write_signal(json, drive.motion.front().signal());
  }
  json.end_object();
}

class ParameterReader {
 public:
  explicit ParameterReader(const JsonDocument& document) : doc_(document) {}

  JointParameters read(const JsonNode& node) const {
    doc_.require_known(doc_.object(node, "`parameters`"),
                       {"damping", "stiffness", "rest", "armature", "effort", "limits", "friction", "strength", "drive"});
    JointParameters p;
    p.damping = values(node, "damping"), p.stiffness = values(node, "stiffness"), p.rest = values(node, "rest");
    p.armature = values(node, "armature"), p.effort = values(node, "effort");
    if (const JsonNode* limits = node.find("limits")) p.limits = read_limits(*limits);
    if (const JsonNode* friction = node.find("friction")) {
      doc_.require_known(doc_.object(*friction, "`friction`"), {"coulomb", "speed"});
      p.friction = {values(*friction, "coulomb"), values(*friction, "speed")};
    }
    if (const JsonNode* strength = node.find("strength")) {
      doc_.require_known(doc_.object(*strength, "`strength`"), {"force", "torque"});
      p.strength = {number(*strength, "force", infinity), number(*strength, "torque", infinity)};
    }
    if (const JsonNode* drive = node.find("drive")) p.drive = read_drive(*drive);
    return p;
  }

 private:
  static std::string quoted(const char* key) { return '`' + std::string(key) + '`'; }

  double number(const JsonNode& node, const char* key, double none) const {
    const JsonNode* given = node.find(key);
    return given == nullptr || given->is(Type::null) ? none : doc_.number(*given, quoted(key));
  }

  // `none`: the value of null; if it is NaN, null is refused.
  Values values(const JsonNode& node, const char* key, double none = NAN) const {
    const JsonNode* given = node.find(key);
    if (given == nullptr) return {};
    const bool nulls = !std::isnan(none);
    if (nulls && given->is(Type::null)) return none;
    if (given->is(Type::number)) return given->number;
    Values all;
    for (const JsonNode& item : doc_.array(*given, quoted(key)).items) {
      if (all.size() == Values::capacity) doc_.fail_at(*given, quoted(key) + " has too many numbers");
      all.push_back(nulls && item.is(Type::null) ? none : doc_.number(item, "a number of " + quoted(key)));
    }
    return all;
  }

  JointLimits read_limits(const JsonNode& node) const {
    doc_.require_known(doc_.object(node, "`limits`"), {"lower", "upper", "restitution", "rest_speed", "stiffness", "damping"});
    JointLimits limits;
    limits.lower = values(node, "lower", -infinity), limits.upper = values(node, "upper", infinity);
    limits.restitution = values(node, "restitution");
    limits.stiffness = values(node, "stiffness"), limits.damping = values(node, "damping");
    limits.rest_speed = number(node, "rest_speed", limits.rest_speed);
    return limits;
  }

  Signal signal(const JsonNode& node) const {
    if (node.is(Type::number)) return node.number;
    doc_.require_known(doc_.object(node, "a value that changes with time"),
                       {"table", "ends", "sine", "rate", "offset", "from_here"});
    try {
      if (node.find("rate") != nullptr) {
        const Signal ramp = Signal::ramp(number(node, "rate", 0), number(node, "offset", 0));
        const JsonNode* from_here = node.find("from_here");
        if (from_here == nullptr || !from_here->is(Type::boolean) || from_here->number == 0) return ramp;
        return Signal::ramp_from_here(ramp.ramp_rate()).begun_at(ramp.offset(), 0);
      }
      if (const JsonNode* table = node.find("table")) {
        std::vector<Signal::Knot> knots;
        for (const JsonNode& item : doc_.array(*table, "`table`").items) {
          const std::vector<double> pair = doc_.numbers(item, "an entry of `table`");
          if (pair.size() != 2) doc_.fail_at(item, "an entry of `table` should be [time, value]");
          knots.push_back({pair[0], pair[1]});
        }
        const JsonNode* ends = node.find("ends");
        const bool free = ends != nullptr && doc_.string(*ends, "`ends`") == "free";
        return Signal::table(std::move(knots), free ? Signal::Ends::free : Signal::Ends::rest);
      }
      if (const JsonNode* sine = node.find("sine")) {
        doc_.require_known(doc_.object(*sine, "`sine`"), {"amplitude", "frequency", "phase", "offset"});
        return Signal::sine(number(*sine, "amplitude", 0), number(*sine, "frequency", 0), number(*sine, "phase", 0),
                            number(*sine, "offset", 0));
      }
    } catch (const Error& error) {
      if (!error.where.empty()) throw;
      doc_.fail_at(node, error.problem, error.hint);
    }
    doc_.fail_at(node, "a value that changes with time should be a number, a `table`, a `sine` or a `rate`");
  }

  std::vector<Signal> signals(const JsonNode& node, const char* key) const {
    const JsonNode* given = node.find(key);
    if (given == nullptr) return {};
    std::vector<Signal> all;
    for (const JsonNode& item : doc_.array(*given, quoted(key)).items) all.push_back(signal(item));
    return all;
  }

  std::shared_ptr<const JointDrive> read_drive(const JsonNode& node) const {
    doc_.require_known(doc_.object(node, "`drive`"), {"effort", "pd", "motion"});
    JointDrive drive;
    drive.effort = signals(node, "effort");
    if (const JsonNode* pd = node.find("pd")) {
      doc_.require_known(doc_.object(*pd, "`pd`"), {"kp", "kd", "target", "target_speed", "max_effort"});
      drive.pd.kp = values(*pd, "kp"), drive.pd.kd = values(*pd, "kd");
      drive.pd.target = signals(*pd, "target"), drive.pd.target_speed = signals(*pd, "target_speed");
      drive.pd.max_effort = values(*pd, "max_effort", infinity);
    }
    if (const JsonNode* motion = node.find("motion")) drive.motion.emplace_back(signal(*motion));
    return std::make_shared<const JointDrive>(std::move(drive));
  }

  const JsonDocument& doc_;
};

}  // namespace

void write_parameters(JsonWriter& json, const JointParameters& p) {
  json.begin_object();
  write_values(json, "damping", p.damping);
  write_values(json, "stiffness", p.stiffness);
  write_values(json, "rest", p.rest);
  write_values(json, "armature", p.armature);
  write_values(json, "effort", p.effort);
  if (p.limits.any()) write_limits(json, p.limits);
  if (p.friction.given()) {
    json.key("friction").begin_object();
    write_values(json, "coulomb", p.friction.coulomb);
    write_values(json, "speed", p.friction.speed);
    json.end_object();
  }
  if (p.strength.any())
    json.key("strength").begin_object().member("force", p.strength.force).member("torque", p.strength.torque).end_object();
  if (p.drive) write_drive(json, *p.drive);
  json.end_object();
}

JointParameters parameters_of(const JsonDocument& document, const JsonNode& node) { return ParameterReader(document).read(node); }

}  // namespace momentree::io
