// Invalid drives, friction, soft stops, strengths, and forces on bodies are refused.
#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

TEST_CASE("values that change with time") {
  const auto effort = [](const std::string& value) { return pinned + "drive = { effort = " + value + " }\n"; };
  const std::string hint = "; for example { table = [[0, 1], [2, 5]] } or { sine = { amplitude = 2, frequency = \"0.5 Hz\" } }";
  check({
      {effort("{ table = [[0, 1], [2, 3], [\"2 s\", 4]] }"),
       "s.toml:10:47: error: effort: the table's times must increase: this entry is not after the one before it; sort the "
       "entries; for a jump, let the value change within a short time"},
      {effort("{ table = [] }"), "s.toml:10:30: error: effort: the table is empty; for example table = [[0, 1], [\"2 s\", 5]]"},
      {effort("{ table = 3 }"),
       "s.toml:10:30: error: effort: expected a list of [time, value], found a number; for example table = [[0, 1], [\"2 s\", "
       "5]]"},
      {effort("{ table = [[0, 1], [1]] }"),
       "s.toml:10:39: error: effort: expected [time, value], found a list of 1; for example table = [[0, 1], [\"2 s\", 5]]"},
      {effort("{ table = [[0, \"1 N\"]] }"),
       "s.toml:10:35: error: effort: '1 N' is a force (N), not a torque (N m); for example 2, or \"2 N m\""},
      {effort("{ table = [[\"1 m\", 1]] }"),
       "s.toml:10:32: error: effort: '1 m' is a length (m), not a time (s); for example 2, or \"2 s\""},
      {effort("{ }"), "s.toml:10:20: error: effort: expected a number, { table = … }, { sine = … } or { rate = … }" + hint},
      {effort("{ table = [[0, 1]], sine = { amplitude = 1, frequency = 1 } }"),
       "s.toml:10:20: error: effort: is one of 'table', 'sine' and 'rate', not several" + hint},
      {effort("{ table = [[0, 1], [1, 2]], ends = \"free\" }"),
       "s.toml:10:55: error: ends: this key is for tables that are motions; others are linear between their entries; leave "
       "'ends' "
       "out"},
      {effort("{ sine = { amplitude = 1, frequency = 1 }, offset = 1 }"),
       "s.toml:10:72: error: offset: belongs to a 'rate'; put it into the sine's own table"},
      {effort("{ rate = \"2 N m\" }"),
       "s.toml:10:29: error: rate: '2 N m' is a torque (N m), not a quantity in kg m^2 s^-3; for example 2, in SI units"},
      {effort("{ tabel = [[0, 1]] }"), "s.toml:10:22: error: unknown key 'tabel' in effort; did you mean 'table'?"},
      {effort("{ sine = { amplitude = 1 } }"), "s.toml:10:29: error: sine has no 'frequency'; in Hz: cycles per second"},
      {effort("{ sine = { amplitude = 1, frequency = \"3 rad/s\" } }"),
       "s.toml:10:58: error: frequency: '3 rad/s' is an angular speed (rad/s), not a frequency (Hz); for example 0.5, or \"0.5 "
       "Hz\""},
      {effort("{ sine = { amplitude = 1, frequency = 1, phase = \"1 s\" } }"),
       "s.toml:10:69: error: phase: '1 s' is a time (s), not an angle (rad); for example 0.5236, or \"30 deg\""},
      {effort("{ sine = { amplitude = 1, frequency = 1, fase = 1 } }"),
       "s.toml:10:61: error: unknown key 'fase' in sine; write 'phase', as in phase = \"90 deg\""},
  });
}

TEST_CASE("invalid drives are refused") {
  const std::string ball = one_body + "[mechanism.body.joint]\nkind = \"ball\"\n";
  check({
      {pinned + "drive = { }\n",
       "s.toml:10:9: error: drive: drives nothing; one of effort, pd and motion; effort = 0 removes a drive"},
      {pinned + "drive = { pdd = { kp = 1 } }\n", "s.toml:10:11: error: unknown key 'pdd' in drive; did you mean 'pd'?"},
      {pinned + "drive = { pd = { target = 1 } }\n",
       "s.toml:10:16: error: pd: has neither 'kp' nor 'kd'; the effort is kp·(target − q) + kd·(target_speed − v)"},
      {pinned + "drive = { pd = { kp = -1, target = 1 } }\n", "s.toml:10:23: error: kp: must not be negative"},
      {pinned + "drive = { pd = { kp = 1, target = \"1 m\" } }\n",
       "s.toml:10:35: error: target: '1 m' is a length (m), not an angle (rad); for example 0.5236, or \"30 deg\""},
      {pinned + "drive = { pd = { kp = 1, max_effort = 0 } }\n",
       "s.toml:10:39: error: max_effort: must be greater than 0; leave it out if there is no bound"},
      {ball + "drive = { pd = { kp = 1 } }\n",
       "s.toml:10:16: error: pd: a ball joint has no coordinates that could follow a target"},
      {ball + "drive = { motion = 1 }\n",
       "s.toml:10:20: error: motion: a ball joint has 3 degrees of freedom: a motion is for joints with one degree of freedom; "
       "use pd with a stiff "
       "kp, one "
       "target per degree of freedom"},
      {ball + "drive = { effort = [1, 2] }\n",
       "s.toml:10:20: error: effort: expected 3 values, found a list of 2; one per degree of freedom or coordinate, in the order "
       "of the joint kind"},
      {pinned + "drive = { motion = 1, effort = 2 }\n",
       "s.toml:10:32: error: effort: a joint whose motion is prescribed takes the effort that it needs; leave out 'effort' or "
       "'motion'"},
      {pinned + "angle = \"0.5 rad\"\ndrive = { motion = { sine = { amplitude = 2, frequency = 1 } } }\n",
       "s.toml:10:9: error: the joint's motion starts at the position 0, not 0.5; leave the start position out: the motion gives "
       "it"},
      {pinned + "speed = 1\ndrive = { motion = { table = [[0, 1], [1, 2]] } }\n",
       "s.toml:10:9: error: the joint's motion starts at the speed 0, not 1; leave the start speed out: the motion gives it"},
      {head + "state = { joints = { a = 2 } }\n" + pinned.substr(head.size()) + "drive = { motion = 1 }\n",
       "s.toml:4:26: error: the joint's motion starts at the position 1, not 2; leave the start position out: the motion gives "
       "it"},
      {chain + "inertia = 1\nangle = 1\ndrive = { motion = 1 }\n",
       "s.toml:9:9: error: angle: the motion of these joints defines where they start; leave it out"},
  });
}

TEST_CASE("invalid friction, soft stops and strengths are refused") {
  check({
      {pinned + "friction = { coulomb = 1 }\n",
       "s.toml:10:12: error: friction has no 'speed'; the friction fades below it: use about a hundredth of the joint's usual "
       "speed"},
      {pinned + "friction = { coulomb = -1, speed = 1 }\n", "s.toml:10:24: error: coulomb: must not be negative"},
      {pinned + "friction = { coulomb = 1, speed = 0 }\n",
       "s.toml:10:35: error: speed: must be greater than 0; friction is smoothed over it: coulomb·tanh(v/speed)"},
      {pinned + "friction = { coulomb = \"1 N\", speed = 1 }\n",
       "s.toml:10:24: error: coulomb: '1 N' is a force (N), not a torque (N m); for example 2, or \"2 N m\""},
      {pinned + "limits = { lower = 0, upper = 1, stiffness = 0 }\n",
       "s.toml:10:46: error: stiffness: must be greater than 0; leave it out for a hard stop"},
      {pinned + "limits = { lower = 0, damping = 1 }\n",
       "s.toml:10:33: error: limits: 'damping' goes with 'stiffness'; a hard stop dissipates energy by 'restitution'"},
      {pinned + "limits = { lower = 0, stiffness = 1, restitution = 1 }\n",
       "s.toml:10:52: error: limits: a stop with 'stiffness' is soft and has no 'restitution'; leave out one of the two"},
      {pinned + "strength = { }\n",
       "s.toml:10:12: error: strength: neither 'force' nor 'torque'; for example strength = { force = \"4 kN\" }"},
      {pinned + "strength = { force = 0 }\n",
       "s.toml:10:22: error: force: must be greater than 0; the load at which the joint breaks; leave it out if the joint bears "
       "any load"},
      {pinned + "strength = { torque = \"4 N\" }\n",
       "s.toml:10:23: error: torque: '4 N' is a force (N), not a torque (N m); for example 2, or \"2 N m\""},
      {chain + "inertia = 1\nstrength = { force = -1 }\n",
       "s.toml:9:22: error: force: must be greater than 0; the load at which the joint breaks; leave it out if the joint bears "
       "any load"},
  });
}

TEST_CASE("invalid forces on bodies are refused") {
  const std::string force = pinned + "[[force]]\n";
  check({
      {force,
       "s.toml:10:1: error: [[force]] has no 'body'; the body on which it acts, or \"chain/*\" for each\n"
       "s.toml:10:1: error: [[force]] does nothing; give force, torque or drag: force = [\"10 N\", 0, 0]"},
      {force + "body = \"m/b\"\nforce = [1, 0, 0]\n", "s.toml:11:8: error: force: there is no body 'm/b'; did you mean 'm/a'?"},
      {force + "body = \"n/*\"\nforce = [1, 0, 0]\n",
       "s.toml:11:8: error: force: no body matches 'n/*'; * matches within a name: \"chain/*\""},
      {force + "body = \"ground\"\nforce = [1, 0, 0]\n",
       "s.toml:11:8: error: force: there is no body 'ground'; the ground does not move"},
      {force + "body = \"m/a\"\nforce = 3\n",
       "s.toml:12:9: error: force: expected three values, found a number; each of them a number, { table = … } or { sine = … }: "
       "[0, 0, { sine = { amplitude = 2, frequency = 1 } }]"},
      {force + "body = \"m/a\"\nforce = [1, 0, \"2 N m\"]\n",
       "s.toml:12:16: error: force: '2 N m' is a torque (N m), not a force (N); for example 4000, or \"4 kN\""},
      {force + "body = \"m/a\"\nforce = [1, 0, 0]\naxes = \"bodies\"\n",
       "s.toml:13:8: error: axes: there is no 'bodies'; \"world\" (the default) or \"body\""},
      {force + "body = \"m/a\"\ndrag = { linear = -1 }\n", "s.toml:12:19: error: linear: must not be negative"},
      {force + "body = \"m/a\"\ndrag = { }\n",
       "s.toml:12:8: error: drag: neither 'linear' nor 'quadratic'; for example drag = { quadratic = \"0.6 kg/m^3\", area = "
       "\"0.5 m^2\" }"},
      {force + "body = \"m/a\"\ndrag = { linear = 1, area = 2 }\n",
       "s.toml:12:29: error: drag: 'area' goes with 'quadratic'; the force is quadratic·area·v²"},
      {force + "body = \"m/a\"\ndrag = { quadratic = \"0.6 kg/m^3\" }\n",
       "s.toml:12:22: error: quadratic: '0.6 kg/m^3' is a density (kg/m^3), not a quadratic drag (N s^2/m^2); for example 0.3, "
       "or \"0.3 N s^2/m^2\""},
      {force + "body = \"m/a\"\nforces = [1, 0, 0]\ntorque = [0, 0, 1]\n",
       "s.toml:12:1: error: unknown key 'forces' in [[force]]; did you mean 'force'?"},
  });
}

TEST_CASE("wildcards of conditions that match nothing, or two things") {
  const std::string event = chain + "inertia = 1\n[[event]]\nbreak = \"m/*\"\n";
  check({
      {event + "when = { reaction_force = \"n/*\", exceeds = 3 }\n",
       "s.toml:11:27: error: when: no joint matches 'n/*'; * matches within a name: \"chain/*\""},
      {event + "when = { distance = [\"m/*\", \"*/1\"], below = 3 }\n",
       "s.toml:11:29: error: when: two wildcards, 'm/*' and '*/1'; one of them should be a name"},
      {event + "when = { reaction_force = \"m/*\", exceeds = 0 }\n",
       "s.toml:11:44: error: when: reaction_force is never negative: the threshold must be positive"},
      {event + "when = { kinetic_energy = \"m*\", exceeds = 1 }\n",
       "s.toml:11:27: error: kinetic_energy: there is no mechanism 'm*'; did you mean 'm'?"},
  });
}
