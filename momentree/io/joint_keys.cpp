#include <momentree/io/joint_keys.hpp>

#include <limits>

namespace momentree::io {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using S = JointSettings;

constexpr JointKey limits[] = {
    {.key = "lower",
     .about = "The lower stop; -inf, or nothing: none",
     .value = [](S& s) -> Values& { return s.parameters.limits.lower; },
     .quantity = Quantity::q,
     .infinite = -infinity},
    {.key = "upper",
     .about = "The upper stop; inf, or nothing: none",
     .value = [](S& s) -> Values& { return s.parameters.limits.upper; },
     .quantity = Quantity::q,
     .infinite = infinity},
    {.key = "restitution",
     .about = "Hard stops: the share of the speed that is left after a rebound, from 0 (plastic, the default) to 1",
     .value = [](S& s) -> Values& { return s.parameters.limits.restitution; },
     .range = Range::fraction,
     .by_model = true},
    {.key = "stiffness",
     .about = "Soft stops push back with stiffness·penetration + damping·v",
     .value = [](S& s) -> Values& { return s.parameters.limits.stiffness; },
     .quantity = Quantity::stiffness,
     .range = Range::positive,
     .hint = "leave it out for a hard stop"},
    {.key = "damping",
     .about = "Damping of soft stops",
     .value = [](S& s) -> Values& { return s.parameters.limits.damping; },
     .quantity = Quantity::damping,
     .range = Range::not_negative},
    {.key = "rest_speed",
     .about = "Hard stops: below this speed the joint comes to rest on the stop",
     .value = [](S& s) -> double& { return s.parameters.limits.rest_speed; },
     .quantity = Quantity::v,
     .range = Range::positive,
     .by_model = true}};

constexpr JointKey friction[] = {{.key = "coulomb",
                                  .about = "Torque or force of sliding",
                                  .value = [](S& s) -> Values& { return s.parameters.friction.coulomb; },
                                  .quantity = Quantity::effort,
                                  .range = Range::not_negative,
                                  .required = "for example friction = { coulomb = \"2 N m\", speed = \"0.01 rad/s\" }"},
                                 {.key = "speed",
                                  .about = "Speed over which the friction builds up: a small fraction of the speeds that matter",
                                  .value = [](S& s) -> Values& { return s.parameters.friction.speed; },
                                  .quantity = Quantity::v,
                                  .range = Range::positive,
                                  .hint = "friction is smoothed over it: coulomb·tanh(v/speed)",
                                  .required = "the friction fades below it: use about a hundredth of the joint's usual speed"}};

constexpr JointKey strength[] = {{.key = "force",
                                  .about = "Norm of the reaction force at which the joint breaks",
                                  .value = [](S& s) -> double& { return s.parameters.strength.force; },
                                  .quantity = Quantity::force,
                                  .range = Range::positive,
                                  .hint = "the load at which the joint breaks; leave it out if the joint bears any load",
                                  .infinite = infinity},
                                 {.key = "torque",
                                  .about = "Norm of the reaction torque at which the joint breaks",
                                  .value = [](S& s) -> double& { return s.parameters.strength.torque; },
                                  .quantity = Quantity::torque,
                                  .range = Range::positive,
                                  .hint = "the load at which the joint breaks; leave it out if the joint bears any load",
                                  .infinite = infinity}};

constexpr JointKey pd[] = {{.key = "kp",
                            .about = "Stiffness",
                            .value = [](S& s) -> Values& { return s.drive.pd.kp; },
                            .quantity = Quantity::stiffness,
                            .range = Range::not_negative},
                           {.key = "kd",
                            .about = "Damping",
                            .value = [](S& s) -> Values& { return s.drive.pd.kd; },
                            .quantity = Quantity::damping,
                            .range = Range::not_negative},
                           {.key = "target",
                            .about = "Position to hold; default: the joint's zero",
                            .value = [](S& s) -> std::vector<Signal>& { return s.drive.pd.target; },
                            .quantity = Quantity::q},
                           {.key = "target_speed",
                            .about = "Speed to hold; default: the rate of the target",
                            .value = [](S& s) -> std::vector<Signal>& { return s.drive.pd.target_speed; },
                            .quantity = Quantity::v},
                           {.key = "max_effort",
                            .about = "Bound of the effort, in either direction",
                            .value = [](S& s) -> Values& { return s.drive.pd.max_effort; },
                            .quantity = Quantity::effort,
                            .range = Range::positive,
                            .hint = "leave it out if there is no bound",
                            .infinite = infinity}};

constexpr JointKey drive[] = {
    {.key = "effort",
     .about = "Driving torque or force",
     .value = [](S& s) -> std::vector<Signal>& { return s.drive.effort; },
     .quantity = Quantity::effort},
    {.key = "pd",
     .about = "Position control: kp·(target − q) + kd·(target_speed − v), at most max_effort in either direction",
     .value = JointGroup{pd,
                         {"kp", "kd"},
                         "has neither 'kp' nor 'kd'",
                         "the effort is kp·(target − q) + kd·(target_speed − v)",
                         "follow a target"}},
    {.key = "motion",
     .about = "Prescribed position of a joint with one degree of freedom; the drive supplies whatever effort it needs",
     .value = [](S& s) -> std::vector<Signal>& { return s.motion; },
     .quantity = Quantity::q,
     .one_dof = true}};

constexpr JointKey parameters[] = {
    {.key = "damping",
     .about = "Torque or force −damping·v",
     .value = [](S& s) -> Values& { return s.parameters.damping; },
     .quantity = Quantity::damping,
     .range = Range::not_negative,
     .by_model = true},
    {.key = "stiffness",
     .about = "Spring about `rest`",
     .value = [](S& s) -> Values& { return s.parameters.stiffness; },
     .quantity = Quantity::stiffness,
     .range = Range::not_negative,
     .by_model = true},
    {.key = "rest",
     .about = "Coordinates at which the spring is relaxed; default: the joint's zero",
     .value = [](S& s) -> Values& { return s.parameters.rest; },
     .quantity = Quantity::q,
     .each = true},
    {.key = "armature",
     .about = "Rotor inertia reflected to the joint, added to the joint-space mass",
     .value = [](S& s) -> Values& { return s.parameters.armature; },
     .quantity = Quantity::armature,
     .range = Range::not_negative,
     .by_model = true},
    {.key = "effort",
     .about = "Constant driving torque or force: in scenarios a part of the drive",
     .value = [](S& s) -> Values& { return s.parameters.effort; },
     .quantity = Quantity::effort,
     .documents = true},
    {.key = "limits",
     .about = "Stops of the joint's coordinates: hard with `restitution`, soft with `stiffness`",
     .value =
         JointGroup{
             limits, {"lower", "upper"}, "for example limits = { lower = \"-90 deg\", upper = \"90 deg\" }", "be limited"}},
    {.key = "friction", .about = "Dry friction, smoothed: −coulomb·tanh(v/speed)", .value = JointGroup{friction}},
    {.key = "strength",
     .about = "The joint breaks when its reaction reaches one of these",
     .value =
         JointGroup{
             strength, {"force", "torque"}, "neither 'force' nor 'torque'", "for example strength = { force = \"4 kN\" }"}},
    {.key = "drive",
     .about = "What drives the joint: an effort, position control or a prescribed motion",
     .value = JointGroup{drive}}};

constexpr SignalKey sine[] = {
    {.key = "amplitude",
     .about = "Amplitude",
     .unit = SignalKey::Unit::value,
     .number = &SignalParts::amplitude,
     .required = "for example sine = { amplitude = 2, frequency = \"0.5 Hz\" }"},
    {.key = "frequency",
     .about = "Cycles per second",
     .unit = SignalKey::Unit::frequency,
     .number = &SignalParts::frequency,
     .required = "in Hz: cycles per second",
     .range = Range::not_negative},
    {.key = "phase", .about = "Phase at time 0", .unit = SignalKey::Unit::angle, .number = &SignalParts::phase},
    {.key = "offset", .about = "Mean value", .unit = SignalKey::Unit::value, .number = &SignalParts::offset}};

constexpr SignalKey ramp[] = {{.key = "rate",
                               .about = "The value is offset + rate·t",
                               .unit = SignalKey::Unit::value_per_time,
                               .number = &SignalParts::rate,
                               .required = ""},
                              {.key = "offset",
                               .about = "Value at time 0; a motion without it starts at the joint's position",
                               .unit = SignalKey::Unit::value,
                               .number = &SignalParts::offset}};

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
