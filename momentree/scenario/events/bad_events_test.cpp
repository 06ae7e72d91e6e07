#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

TEST_CASE("impossible events are refused") {
  check({
      {pinned + "[[event]]\nat = 1\nbreak = \"m/b\"\n",
       "s.toml:12:9: error: break: there is no joint 'm/b'; did you mean 'm/a'?"},
      {pinned + "[[event]]\nat = 1\nbreak = \"a\"\n",
       "s.toml:12:9: error: break: there is no joint 'a'; use the full name: 'm/a'"},
      {pinned + "[[event]]\nat = -1\nbreak = \"m/a\"\n", "s.toml:11:6: error: at: must not be negative"},
      {pinned + "[[event]]\nat = nan\nbreak = \"m/a\"\n", "s.toml:11:6: error: at: must be finite"},
      {pinned + "[[event]]\nat = \"1 kg\"\nbreak = \"m/a\"\n",
       "s.toml:11:6: error: at: '1 kg' is a mass (kg), not a time (s); for example 2, or \"2 s\""},
      {pinned + "[[event]]\nat = 1\nbreak = \"x/*\"\n",
       "s.toml:12:9: error: break: no joint matches 'x/*'; * matches within a name: \"chain/*\""},
      {pinned + "[[event]]\nat = 1\nbreak = []\n", "s.toml:12:9: error: break: names no joint"},
      {pinned + "[[event]]\nat = 1\nbreak = 3\n", "s.toml:12:9: error: break: expected a string, found a number; write \"3\""},
      {pinned + "[[event]]\nbreak = \"m/a\"\n",
       "s.toml:10:1: error: event '#1' has no instant; for example at = \"1.8 s\", or when = { "
       "reaction_force = \"crane/hook\", exceeds = \"4 kN\" }"},
      {pinned + "[[event]]\nat = 1\n", "s.toml:10:1: error: event '#1' does nothing; for example break = \"chain/41\""},
      {pinned + "[[event]]\nat = 1\nbreak = \"m/a\"\n[[event]]\nat = 2\nbreak = \"m/a\"\n",
       "s.toml:15:9: error: break: joint 'm/a' is broken already on line 12; a joint can break only once"},
      {pinned + "[[event]]\nat = 1\nbreak = [\"m/a\", \"m/a\"]\n",
       "s.toml:12:17: error: break: joint 'm/a' is broken already on line 12; a joint can break only once"},
      {pinned + "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\nparent = "
                "\"a\"\n[[event]]\nname = \"x\"\nat = 1\nbreak = \"m/a\"\n[[event]]\nname = \"x\"\nat = 2\nbreak = \"m/b\"\n",
       "s.toml:22:8: error: duplicate event 'x': the name is already used by another on line 18"},
      {one_body + "[mechanism.body.joint]\nname = \"h\"\nkind = \"revolute\"\n[[event]]\nat = 1\nbreak = \"m/a\"\n",
       "s.toml:13:9: error: break: there is no joint 'm/a'; the joint of that body is 'm/h'"},
      {chain + "[[event]]\nat = 1\nbreak = \"m/2\"\n",
       "s.toml:10:9: error: break: the part that separates at 'm/2' lacks the mass or inertia to move freely; give it a mass "
       "and an inertia about every axis"},
  });
}

TEST_CASE("impossible steps are refused") {
  check({
      {pinned + "[integrate]\nstep = 0\n", "s.toml:11:8: error: step: must be greater than 0"},
      {pinned + "[integrate]\nstep = \"-1 ms\"\n", "s.toml:11:8: error: step: must be greater than 0"},
      {pinned + "[integrate]\nuntil = -1\n", "s.toml:11:9: error: until: must not be negative"},
      {pinned + "[integrate]\nmethod = \"rk5\"\n",
       "s.toml:11:10: error: unknown method 'rk5'; write method = \"dopri5\", the Runge-Kutta method of Dormand and Prince that "
       "chooses its steps"},
      {pinned + "[integrate]\nevent_tolerance = 0\n", "s.toml:11:19: error: event_tolerance: must be greater than 0"},
      {pinned + "[output]\nevery = -1\n", "s.toml:11:9: error: every: must not be negative"},
  });
}

TEST_CASE("tolerances must be positive, of use to the method, and such as the state can resolve") {
  const std::string adaptive = "[integrate]\nmethod = \"dopri5\"\n";
  check({
      {pinned + adaptive + "rtol = 0\n", "s.toml:12:8: error: rtol: must be greater than 0"},
      {pinned + adaptive + "atol = -1e-9\n", "s.toml:12:8: error: atol: must be greater than 0"},
      {pinned + adaptive + "max_step = 0\n", "s.toml:12:12: error: max_step: must be greater than 0"},
      {pinned + adaptive + "rtl = 1e-9\n", "s.toml:12:1: error: unknown key 'rtl' in [integrate]; did you mean 'rtol'?"},
  });
  const auto warned = [](const std::string& text) {
    const momentree::io::ReadResult result = momentree::io::read_scenario_text(text, "s.toml");
    CHECK(result.scenario);
    return said(result);
  };
  CHECK(warned(pinned + adaptive + "rtol = 1e-9\natol = 1e-12\nmax_step = \"5 ms\"\n").empty());
  CHECK(warned(pinned + "[integrate]\nrtol = 1e-9\n") ==
        "s.toml:11:8: warning: 'rtol' has no effect: method 'rk4' has fixed steps; use method = \"dopri5\", which chooses its "
        "steps");
  CHECK(warned(pinned + adaptive + "rtol = 1e-16\n") ==
        "s.toml:12:8: warning: rtol = 1e-16 is below the resolution of the velocities of this mechanism; they are known to "
        "about 1e-16: use rtol = 1e-15 or more");
  const std::string long_chain = warned(head + "[mechanism.chain]\nlinks = 100\nlength = \"5 m\"\nmass = \"10 g\"\n" + adaptive +
                                        "variables = \"momenta\"\nrtol = 1e-11\n");
  CHECK(long_chain.find("rtol = 1e-11 is below") != std::string::npos);
}

TEST_CASE("an event tolerance below the resolution of the clock is reported") {
  const auto warned = [](const std::string& keys) {
    return said(momentree::io::read_scenario_text(pinned + "[integrate]\nuntil = 3\nevent_tolerance = " + keys + "\n", "s.toml"));
  };
  CHECK(warned("1e-12") == "");
  CHECK(warned("1e-15") ==
        "s.toml:12:19: warning: event_tolerance = 1e-15 s is below the resolution of the clock: at the end of the run, 3 s, "
        "instants "
        "are 4.4e-16 s apart; use 4e-15 s or more");
}

TEST_CASE("unsupported keys are refused with their places") {
  check({
      {head + "model = \"x.urdf\"\n[[event]]\nat = 1\nbreak = \"m/elbow\"\n",
       "s.toml:4:9: error: model: a scenario read from text cannot name files; read it from its file"},
      {pinned + "[integrate]\nmethod = \"dampened\"\n", "s.toml:11:10: error: unknown method 'dampened'; did you mean 'damped'?"},
  });
}

TEST_CASE("conditions that mean nothing are refused") {
  const std::string event = pinned + "[[event]]\nbreak = \"m/a\"\n";
  check({
      {event + "at = 1\nevery = 1\n",
       "s.toml:10:1: error: event '#1' has more than one of at, when, after and every; write two events"},
      {event + "when = { reaction_force = \"m/b\", exceeds = 1 }\n",
       "s.toml:12:27: error: reaction_force: there is no joint 'm/b'; did you mean 'm/a'?"},
      {event + "when = { reaction_farce = \"m/a\", exceeds = 1 }\n",
       "s.toml:12:10: error: unknown key 'reaction_farce' in when; did you mean 'reaction_force'?"},
      {event + "when = { reaction_force = \"m/a\" }\n", "s.toml:12:8: error: when: has no threshold; exceeds = … or below = …"},
      {event + "when = { reaction_force = \"m/a\", exceeds = 0 }\n",
       "s.toml:12:44: error: when: reaction_force is never negative: the threshold must be positive"},
      {event + "when = { reaction_force = \"m/a\", exceeds = \"4 N m\" }\n",
       "s.toml:12:44: error: exceeds: '4 N m' is a torque (N m), not a force (N); for example 4000, or \"4 kN\""},
      {event + "when = { speed = \"m/a\", exceeds = \"2 m/s\" }\n",
       "s.toml:12:35: error: exceeds: '2 m/s' is a speed (m/s), not an angular speed (rad/s); for example 0.5236, or \"30 "
       "deg/s\""},
      {event + "when = { distance = [\"m/a\"], below = 1 }\n",
       "s.toml:12:21: error: distance: expected a list of two bodies; for example [\"tug/gripper\", \"satellite/hull\"]"},
      {event + "when = { reaction = { joint = \"m/a\", component = \"fw\" }, exceeds = 1 }\n",
       "s.toml:12:50: error: component: there is no 'fw'; one of: fx fy fz mx my mz"},
      {event + "at = 1\nfor = 1\n", "s.toml:13:7: error: 'for' goes with 'when'"},
      {event + "after = { event = \"gone\", delay = 1 }\n",
       "s.toml:12:9: error: after: there is no event 'gone' that could come before"},
      {event + "when = { kinetic_energy = \"n\", exceeds = 1 }\n",
       "s.toml:12:27: error: kinetic_energy: there is no mechanism 'n'"},
  });
}
