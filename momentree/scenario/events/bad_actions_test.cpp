#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

namespace {

// m: a on a revolute joint, b on its ball joint m/j; f: x and y, free; p: z on a revolute joint. 42 lines.
const std::string three = one_body +
                          "[mechanism.body.joint]\nkind = \"revolute\"\n"
                          "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n"
                          "[mechanism.body.joint]\nname = \"j\"\nkind = \"ball\"\nparent = \"a\"\n"
                          "[[mechanism]]\nname = \"f\"\nroot = \"free\"\n"
                          "[[mechanism.body]]\nname = \"x\"\nmass = 1\ninertia = 1\n"
                          "[[mechanism.body]]\nname = \"y\"\nmass = 1\ninertia = 1\n"
                          "[mechanism.body.joint]\nname = \"h\"\nkind = \"revolute\"\nparent = \"x\"\nat = { xyz = [1, 0, 0] }\n"
                          "[[mechanism]]\nname = \"p\"\n"
                          "[[mechanism.body]]\nname = \"z\"\nmass = 1\ninertia = 1\n"
                          "[mechanism.body.joint]\nkind = \"revolute\"\n";
const std::string first = three + "[[event]]\nat = 1\n", then = "[[event]]\nat = 2\n", also = "[[event]]\nat = 1\n";

}  // namespace

TEST_CASE("welds of neighbours are refused") {
  check({
      {first + "weld = { body = \"m/b\", to = \"m/b\" }\n", "s.toml:44:8: error: weld: body 'm/b' can't be joined to itself"},
      {first + "weld = { body = \"m/b\", to = \"m/a\" }\n",
       "s.toml:44:8: error: weld: 'm/b' and 'm/a' are already joined by joint 'm/j'; lock that joint, or change its kind"},
      {first + "weld = { body = \"f/x\", to = \"m/b\" }\n" + then + "weld = { body = \"f/x\", to = \"m/b\" }\n",
       "s.toml:47:8: error: weld: 'f/x' and 'm/b' are already joined by joint 'm/b+f/x'; lock that joint, or change its kind"},
  });
}

TEST_CASE("actions with no effect are refused, with the reason") {
  check({
      {first + "break = \"m/j\"\n" + then + "lock = \"m/j\"\n",
       "s.toml:47:8: error: lock: joint 'm/j' will be broken by then, by break m/j (event '#1', line 44); to hold the separated "
       "part where it is, weld its body to the ground"},
      {first + "break = \"m/a\"\n" + then + "lock = \"m/a\"\n",
       "s.toml:47:8: error: lock: joint 'm/a' will be broken by then, by break m/a (event '#1', line 44); to hold the separated "
       "part where it is, weld its body to the ground"},
      {first + "lock = [\"m/j\", { joint = \"m/j\", freedoms = [0, 1] }]\n",
       "s.toml:44:16: error: lock: does nothing: it is already locked, after lock m/j (event '#1', line 44)"},
      {first + "unlock = \"f/h\"\n", "s.toml:44:10: error: unlock: does nothing: it is not locked"},
      {first + "change = { joint = \"m/j\", kind = \"ball\" }\n",
       "s.toml:44:10: error: change: does nothing: it is already that joint"},
      {first + "free = \"m/j\"\n" + then + "free = \"m/j\"\n",
       "s.toml:47:8: error: free: does nothing: it is already that joint, after free m/j (event '#1', line 44)"},
      {first + "break = \"grasp\"\n[[event]]\nname = \"grasp\"\nat = 2\nweld = { body = \"f/x\" }\n",
       "s.toml:44:9: error: break: joint 'grasp' does not exist yet: it is made later, on line 48"},
  });
}

TEST_CASE("a broken free joint is not the free joint of the part that broke off, although it has its name") {
  std::string text = first;
  const std::string ball = "name = \"j\"\nkind = \"ball\"\n", free = "kind = \"free\"\n";
  text.replace(text.find(ball), ball.size(), free);
  check({
      {text + "break = \"m/b\"\n" + then + "change = { joint = \"m/b\", kind = \"ball\" }\n",
       "s.toml:46:10: error: change: joint 'm/b' will be broken by then, by break m/b (event '#1', line 43); to hold the "
       "separated part where it is, weld its body to the ground"},
  });
}

TEST_CASE("what an action sets on a joint that could not be read is not judged") {
  std::string text = first + "set = { joint = \"p/z\", damping = \"2 N m s\" }\n";
  const std::size_t mass = text.rfind("mass = 1");
  text.replace(mass, 8, "mass = true");
  check({{text, "s.toml:38:8: error: mass: expected a mass (kg), found true or false; for example 0.2, or \"200 g\""}});
}

TEST_CASE("contradictory actions at one instant name both") {
  const std::string hint = "; a joint can take only one such change at a time: give the actions different instants";
  check({
      {first + "lock = \"m/j\"\nbreak = \"m/j\"\n",
       "s.toml:45:9: error: break: contradicts lock m/j (event '#1') at the same instant, on line 44" + hint},
      {first + "lock = \"m/j\"\n" + also + "break = \"m/j\"\n",
       "s.toml:47:9: error: break: contradicts lock m/j (event '#1') at the same instant, on line 44" + hint},
      {first + "unlock = { joint = \"m/j\", freedoms = [1] }\n" + also + "lock = \"m/j\"\n",
       "s.toml:47:8: error: lock: contradicts unlock m/j [1] (event '#1') at the same instant, on line 44" + hint},
  });
}

TEST_CASE("impossible joints are refused") {
  check({
      {first + "attach = { body = \"f/x\", to = \"m/b\", kind = \"universal\", axis = [0, 0, 1], axis2 = [0, 0, -2] }\n",
       "s.toml:44:84: error: axis2: is parallel to 'axis': that would be the same degree of freedom twice; for example "
       "perpendicular to it"},
      {first + "attach = { body = \"f/x\", to = \"m/b\" }\n",
       "s.toml:44:10: error: attach has no 'kind'; one of: ball cylindrical free helical planar prismatic revolute universal "
       "weld"},
      {first + "attach = { body = \"f/x\", kind = \"helical\" }\n",
       "s.toml:44:10: error: attach has no 'pitch'; the displacement per turn, for example \"5 mm\""},
      {first + "attach = { body = \"f/x\", kind = \"ball\", limits = { lower = 0 } }\n",
       "s.toml:44:50: error: limits: a ball joint has no coordinates that could be limited"},
      {first + "change = { joint = \"m/j\", kind = \"revolute\" }\n",
       "s.toml:44:10: error: change: a ball joint has no axis for the revolute to take over; give axis, in the child's axes"},
      {first + "change = { joint = \"m/j\", kind = \"revolute\", axis = [0, 0, 0] }\n",
       "s.toml:44:53: error: axis: an axis of length zero has no direction; for example [0, 0, 1]"},
      {first + "change = { joint = \"m/a\", kind = \"universal\", axis2 = [0, 0, 1] }\n",
       "s.toml:44:10: error: change: axis2: is parallel to 'axis': that would be the same degree of freedom twice; for example "
       "perpendicular to "
       "it"},
      {first + "change = { joint = \"m/j\", kind = \"weld\", axis = [0, 0, 1] }\n",
       "s.toml:44:49: error: a weld joint has no 'axis'; joints that have one: cylindrical helical prismatic revolute universal"},
  });
}

TEST_CASE("unknown names are refused") {
  check({
      {first + "lock = \"m/jj\"\n", "s.toml:44:8: error: lock: there is no joint 'm/jj'; did you mean 'm/j'?"},
      {first + "lock = \"m/b\"\n", "s.toml:44:8: error: lock: there is no joint 'm/b'; the joint of that body is 'm/j'"},
      {first + "weld = { body = \"f/w\" }\n", "s.toml:44:17: error: weld: there is no body 'f/w'; did you mean 'f/x'?"},
      {first + "weld = { body = \"f/h\" }\n", "s.toml:44:17: error: weld: there is no body 'f/h'; that is the name of a joint"},
      {first + "weld = { body = \"x\" }\n", "s.toml:44:17: error: weld: there is no body 'x'; use the full name: 'f/x'"},
      {first + "weld = { body = \"ground\", to = \"f/x\" }\n",
       "s.toml:44:17: error: weld: this action cannot be applied to the ground; the ground can only be the body that another is "
       "joined 'to'"},
      {first + "weld = { body = \"f/x\", to = \"m/*\" }\n",
       "s.toml:44:29: error: weld: 'to' is one body: 'm/*' can match several"},
      {first + "impulse = { body = \"q/*\", force = [1, 0, 0] }\n",
       "s.toml:44:20: error: impulse: no body matches 'q/*'; * matches within a name: \"chain/*\""},
      {three + "[[event]]\nname = \"e\"\nat = 1\nlock = \"f/h\"\n" + then + "break = \"e\"\n",
       "s.toml:48:9: error: break: there is no joint 'e'; the event of that name makes no joint"},
      {three + "[[event]]\nname = \"grasp\"\nat = 1\nweld = { body = \"f/x\" }\n" + then + "break = \"grsp\"\n",
       "s.toml:48:9: error: break: there is no joint 'grsp'; did you mean 'grasp'?"},
      {three + "[[event]]\nname = \"grasp\"\nat = 1\nweld = { body = \"f/x\" }\n" + then + "break = \"ground+f/x\"\n",
       "s.toml:48:9: error: break: there is no joint 'ground+f/x'; events make the joint 'grasp'"},
  });
}

TEST_CASE("wrong types, units and degrees of freedom are refused") {
  const std::string count = "; degrees of freedom are numbered in the order of v: [0, 2]";
  check({
      {first + "weld = \"f/x\"\n",
       "s.toml:44:8: error: weld: expected a table, found a string; for example weld = { body = \"satellite/hull\", to = "
       "\"tug/gripper\" }"},
      {first + "weld = []\n", "s.toml:44:8: error: weld: an empty list does nothing"},
      {first + "lock = 3\n", "s.toml:44:8: error: lock: expected a string, found a number; write \"3\""},
      {first + "lock = { joints = \"m/j\" }\n",
       "s.toml:44:8: error: lock has no 'joint'; a name, or for example { joint = \"arm/elbow\", freedoms = [0] }\n"
       "s.toml:44:10: error: unknown key 'joints' in lock; did you mean 'joint'?"},
      {first + "lock = { joint = \"m/j\", freedoms = [0, 3] }\n",
       "s.toml:44:8: error: lock: joint 'm/j' has no degree of freedom 3; a ball joint has degrees of freedom 0 to 2"},
      {first + "lock = { joint = \"m/j\", freedoms = [9] }\n",
       "s.toml:44:37: error: freedoms: expected a number from 0 to 5, not 9" + count},
      {first + "lock = { joint = \"m/j\", freedoms = [1, 1] }\n", "s.toml:44:40: error: freedoms: 1 is given twice"},
      {first + "lock = { joint = \"m/j\", freedoms = [] }\n",
       "s.toml:44:36: error: freedoms: names no degree of freedom; leave it out for all of them"},
      {first + "lock = { joint = \"m/j\", freedoms = 1 }\n",
       "s.toml:44:36: error: freedoms: expected a list, found a number" + count},
      {first + "impulse = { body = \"f/x\", force = [\"1 N\", 2, 3] }\n",
       "s.toml:44:36: error: force: '1 N' is a force (N), not a momentum (N s); for example 2, or \"2 N s\""},
      {first + "impulse = { body = \"f/x\", point = [0, 0, \"1 s\"], force = [1, 2, 3] }\n",
       "s.toml:44:42: error: point: '1 s' is a time (s), not a length (m); for example 0.5, or \"50 cm\""},
      {first + "impulse = { body = \"f/x\" }\n",
       "s.toml:44:11: error: impulse: changes nothing; for example impulse = { body = \"arm/hand\", force = [\"2 N s\", 0, 0] }"},
      {first + "set = { joint = \"m/j\" }\n",
       "s.toml:44:7: error: set: changes nothing; for example set = { joint = \"arm/elbow\", damping = 0.1 }"},
      {first + "set = { joint = \"m/j\", damping = \"3 kg\" }\n",
       "s.toml:44:34: error: damping: '3 kg' is a mass (kg), not a rotational damping (N m s/rad); for example 0.1, or \"0.1 N m "
       "s\""},
      {first + "set = { joint = \"m/a\", damping = -1 }\n", "s.toml:44:34: error: damping: must not be negative"},
      {first + "set = { joint = \"m/j\", drive = { effort = 1 } }\n",
       "s.toml:44:43: error: effort: a ball joint has 3 degrees of freedom: one number is ambiguous; give a list, one effort per "
       "degree of freedom"},
      {first + "set = { joint = \"m/*\", damping = \"3 kg\" }\n",
       "s.toml:44:34: error: damping: '3 kg' is a mass (kg), not a rotational damping (N m s/rad); for example 0.1, or \"0.1 N m "
       "s\""},
      {first + "reroot = \"f/y\"\n",
       "s.toml:42:1: error: event '#1' does nothing; for example break = \"chain/41\"\n"
       "s.toml:44:1: error: unknown key 'reroot' in [[event]]; known here: name at when after every from repeat for locate "
       "hysteresis attach break change free impulse lock set set_length unlock weld"},
      {first + "after = { event = \"x\" }\nlock = \"m/j\"\n",
       "s.toml:42:1: error: event '#1' has more than one of at, when, after and every; write two events"},
  });
}
