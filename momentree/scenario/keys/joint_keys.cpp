#include <momentree/scenario/keys/joint_keys.hpp>

#include <limits>

namespace momentree::io {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using S = JointSettings;
using Q = Quantity;
using R = Range;

constexpr JointKey limits[] = {
    JointKey("lower", [](S& s) -> Values& { return s.parameters.limits.lower; }, Q::q, R::any,
             "Lower stop; -inf or absent: no stop", {.infinite = -infinity}),
    JointKey("upper", [](S& s) -> Values& { return s.parameters.limits.upper; }, Q::q, R::any,
             "Upper stop; inf or absent: no stop", {.infinite = infinity}),
    JointKey("restitution", [](S& s) -> Values& { return s.parameters.limits.restitution; }, Q::none, R::fraction,
             "Hard stops: fraction of the approach speed after the rebound, from 0 (plastic, the default) to 1",
             {.by_model = true}),
    JointKey("stiffness", [](S& s) -> Values& { return s.parameters.limits.stiffness; }, Q::stiffness, R::positive,
             "Soft stops push back with stiffness·penetration + damping·v", {.hint = "leave it out for a hard stop"}),
    JointKey(
        "damping", [](S& s) -> Values& { return s.parameters.limits.damping; }, Q::damping, R::not_negative,
        "Damping of soft stops"),
    JointKey("rest_speed", [](S& s) -> double& { return s.parameters.limits.rest_speed; }, Q::v, R::positive,
             "Hard stops: below this speed the joint comes to rest on the stop", {.by_model = true})};

constexpr JointKey friction[] = {
    JointKey("coulomb", [](S& s) -> Values& { return s.parameters.friction.coulomb; }, Q::effort, R::not_negative,
             "Torque or force of sliding",
             {.required = "for example friction = { coulomb = \"2 N m\", speed = \"0.01 rad/s\" }"}),
    JointKey("speed", [](S& s) -> Values& { return s.parameters.friction.speed; }, Q::v, R::positive,
             "Speed over which the friction builds up: a small fraction of the speeds that matter",
             {.hint = "friction is smoothed over it: coulomb·tanh(v/speed)",
              .required = "the friction fades below it: use about a hundredth of the joint's usual speed"})};

constexpr const char* load = "the load at which the joint breaks; leave it out if the joint bears any load";

constexpr JointKey strength[] = {
    JointKey("force", [](S& s) -> double& { return s.parameters.strength.force; }, Q::force, R::positive,
             "Norm of the reaction force at which the joint breaks", {.hint = load, .infinite = infinity}),
    JointKey("torque", [](S& s) -> double& { return s.parameters.strength.torque; }, Q::torque, R::positive,
             "Norm of the reaction torque at which the joint breaks", {.hint = load, .infinite = infinity})};

constexpr JointKey pd[] = {
    JointKey(
        "kp", [](S& s) -> Values& { return s.drive.pd.kp; }, Q::stiffness, R::not_negative, "Stiffness"),
    JointKey(
        "kd", [](S& s) -> Values& { return s.drive.pd.kd; }, Q::damping, R::not_negative, "Damping"),
    JointKey(
        "target", [](S& s) -> std::vector<Signal>& { return s.drive.pd.target; }, Q::q, R::any,
        "Position to hold; default: the joint's zero"),
    JointKey(
        "target_speed", [](S& s) -> std::vector<Signal>& { return s.drive.pd.target_speed; }, Q::v, R::any,
        "Speed to hold; default: the rate of the target"),
    JointKey("max_effort", [](S& s) -> Values& { return s.drive.pd.max_effort; }, Q::effort, R::positive,
             "Bound of the effort, in either direction", {.hint = "leave it out if there is no bound", .infinite = infinity})};

constexpr JointKey drive[] = {
    JointKey(
        "effort", [](S& s) -> std::vector<Signal>& { return s.drive.effort; }, Q::effort, R::any, "Driving torque or force"),
    JointKey("pd",
             JointGroup{pd,
                        {"kp", "kd"},
                        "has neither 'kp' nor 'kd'",
                        "the effort is kp·(target − q) + kd·(target_speed − v)",
                        "follow a target"},
             "Position control: kp·(target − q) + kd·(target_speed − v), at most max_effort in either direction"),
    JointKey("motion", [](S& s) -> std::vector<Signal>& { return s.motion; }, Q::q, R::any,
             "Prescribed position of a joint with one degree of freedom; the drive supplies whatever effort it needs",
             {.one_dof = true})};

constexpr JointKey parameters[] = {
    JointKey("damping", [](S& s) -> Values& { return s.parameters.damping; }, Q::damping, R::not_negative,
             "Torque or force −damping·v", {.by_model = true}),
    JointKey("stiffness", [](S& s) -> Values& { return s.parameters.stiffness; }, Q::stiffness, R::not_negative,
             "Spring about `rest`", {.by_model = true}),
    JointKey("rest", [](S& s) -> Values& { return s.parameters.rest; }, Q::q, R::any,
             "Coordinates at which the spring is relaxed; default: the joint's zero", {.each = true}),
    JointKey("armature", [](S& s) -> Values& { return s.parameters.armature; }, Q::armature, R::not_negative,
             "Rotor inertia reflected to the joint, added to the joint-space mass", {.by_model = true}),
    JointKey("effort", [](S& s) -> Values& { return s.parameters.effort; }, Q::effort, R::any,
             "Constant driving torque or force: in scenarios a part of the drive", {.documents = true}),
    JointKey("limits",
             JointGroup{limits,
                        {"lower", "upper"},
                        "neither 'lower' nor 'upper'",
                        "for example limits = { lower = \"-90 deg\", upper = \"90 deg\" }",
                        "be limited"},
             "Stops of the joint's coordinates: hard with `restitution`, soft with `stiffness`"),
    JointKey("friction", JointGroup{friction}, "Dry friction, smoothed: −coulomb·tanh(v/speed)"),
    JointKey(
        "strength",
        JointGroup{strength, {"force", "torque"}, "neither 'force' nor 'torque'", "for example strength = { force = \"4 kN\" }"},
        "The joint breaks when its reaction reaches one of these"),
    JointKey("drive", JointGroup{drive}, "Drive: an effort, position control or a prescribed motion")};

using Unit = SignalKey::Unit;

constexpr SignalKey sine[] = {
    {"amplitude", Unit::value, &SignalParts::amplitude, "Amplitude",
     "for example sine = { amplitude = 2, frequency = \"0.5 Hz\" }"},
    {"frequency", Unit::frequency, &SignalParts::frequency, "Cycles per second", "in Hz: cycles per second", R::not_negative},
    {"phase", Unit::angle, &SignalParts::phase, "Phase at time 0"},
    {"offset", Unit::value, &SignalParts::offset, "Mean value"}};

constexpr SignalKey ramp[] = {
    {"rate", Unit::value_per_time, &SignalParts::rate, "The value is offset + rate·t", ""},
    {"offset", Unit::value, &SignalParts::offset, "Value at time 0; a motion without it starts at the joint's position"}};

}  // namespace

Dimension dimension_of(Quantity quantity, char letter) {
  using namespace dimension;
  if (quantity == Quantity::q) return letter == 'r' ? angle : letter == 'm' ? length : number;
  const bool turns = letter == 'r';
  const Dimension rate = turns ? angular_speed : speed, effort = turns ? torque : force;
  switch (quantity) {
    case Quantity::damping: return effort / rate;
    case Quantity::stiffness: return turns ? dimension::torque / angle : dimension::force / length;
    case Quantity::armature: return turns ? inertia : mass;
    case Quantity::effort: return effort;
    case Quantity::none: return number;
    case Quantity::force: return dimension::force;
    case Quantity::torque: return dimension::torque;
    default: return rate;
  }
}

JointSettings::JointSettings(const JointParameters& packed) : parameters(packed) {
  if (!packed.drive) return;
  drive = *packed.drive;
  if (drive.moves()) motion = {drive.motion.front().signal()};
  drive.motion.clear();
  parameters.drive = nullptr;
}

JointParameters JointSettings::packed() const {
  JointParameters all = parameters;
  JointDrive whole = drive;
  if (!motion.empty()) whole.motion.emplace_back(motion.front());
  if (!(whole == JointDrive{})) all.drive = std::make_shared<const JointDrive>(std::move(whole));
  return all;
}

std::span<const JointKey> joint_keys() { return parameters; }
std::span<const SignalKey> sine_keys() { return sine; }
std::span<const SignalKey> ramp_keys() { return ramp; }

Dimension SignalKey::dimension(const Dimension& value) const {
  switch (unit) {
    case Unit::value_per_time: return value / momentree::dimension::time;
    case Unit::frequency: return momentree::dimension::frequency;
    case Unit::angle: return momentree::dimension::angle;
    default: return value;
  }
}

SignalParts::SignalParts(const Signal& signal)
    : table(signal.knots().begin(), signal.knots().end()),
      ends(signal.ends()),
      amplitude(signal.amplitude()),
      frequency(signal.frequency()),
      phase(signal.phase()),
      offset(signal.offset()),
      rate(signal.ramp_rate()),
      from_here(signal.from_here()) {
  if (!table.empty())
    form = Form::table;
  else if (rate != 0 || from_here)
    form = Form::ramp;
  else if (!(signal == Signal(offset)))
    form = Form::sine;
}

Signal SignalParts::signal() const {
  switch (form) {
    case Form::table: return Signal::table(table, ends);
    case Form::sine: return Signal::sine(amplitude, frequency, phase, offset);
    case Form::ramp: return from_here ? Signal::ramp_from_here(rate).begun_at(offset, 0) : Signal::ramp(rate, offset);
    default: return offset;
  }
}

}  // namespace momentree::io
