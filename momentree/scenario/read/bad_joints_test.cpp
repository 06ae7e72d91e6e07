#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

TEST_CASE("impossible joints are refused") {
  check({
      {one_body + "[mechanism.body.joint]\nkind = \"revolut\"\n",
       "s.toml:9:8: error: unknown joint kind 'revolut'; did you mean 'revolute'?"},
      {one_body + "[mechanism.body.joint]\nkind = \"hinge\"\n",
       "s.toml:9:8: error: unknown joint kind 'hinge'; write kind = \"revolute\""},
      {one_body + "[mechanism.body.joint]\nkind = \"qqqq\"\n",
       "s.toml:9:8: error: unknown joint kind 'qqqq'; one of: ball cylindrical free helical planar prismatic revolute universal "
       "weld"},
      {one_body + "[mechanism.body.joint]\naxis = [0, 0, 1]\n",
       "s.toml:8:1: error: [mechanism.body.joint] has no 'kind'; one of: ball cylindrical free helical planar prismatic revolute "
       "universal weld"},
      {pinned + "axis = [0, 0, 0]\n", "s.toml:10:8: error: axis: an axis of length zero has no direction; for example [0, 0, 1]"},
      {pinned + "axis = [0, 0, 1e-12]\n",
       "s.toml:10:8: error: axis: an axis of length zero has no direction; for example [0, 0, 1]"},
      {one_body + "[mechanism.body.joint]\nkind = \"universal\"\n",
       "s.toml:8:1: error: [mechanism.body.joint] has no 'axis2'; the second axis, turned by the first rotation, for example [0, "
       "1, 0]"},
      {one_body + "[mechanism.body.joint]\nkind = \"universal\"\naxis2 = [0, 0, -2]\n",
       "s.toml:10:9: error: axis2: is parallel to 'axis': that would be the same degree of freedom twice; for example "
       "perpendicular to it"},
      {one_body + "[mechanism.body.joint]\nkind = \"ball\"\naxis = [0, 0, 1]\n",
       "s.toml:10:8: error: a ball joint has no 'axis'; joints that have one: cylindrical helical prismatic revolute universal"},
      {one_body + "[mechanism.body.joint]\nkind = \"helical\"\n",
       "s.toml:8:1: error: [mechanism.body.joint] has no 'pitch'; the displacement per turn, for example \"5 mm\""},
      {one_body + "[mechanism.body.joint]\nkind = \"helical\"\npitch = 0\n",
       "s.toml:10:9: error: pitch: a pitch of zero does not move along the axis; use a revolute joint"},
      {pinned + "pitch = 1\n", "s.toml:10:9: error: a revolute joint has no 'pitch'; joints that have one: helical"},
      {pinned + "damping = -1\n", "s.toml:10:11: error: damping: must not be negative"},
      {pinned + "damping = [1, 1]\n",
       "s.toml:10:11: error: damping: expected 1 number, found a list of 2; one per degree of freedom or coordinate, in the "
       "order of the joint kind"},
      {pinned + "q = [1, 2]\n",
       "s.toml:10:5: error: q: expected 1 number, found a list of 2; one per degree of freedom or coordinate, in the order of "
       "the joint kind"},
      {one_body + "[mechanism.body.joint]\nkind = \"ball\"\nq = [0, 0, 0, 0]\n",
       "s.toml:10:5: error: q: a quaternion of zeros is not a rotation; the identity is [1, 0, 0, 0]"},
      {one_body + "[mechanism.body.joint]\nkind = \"ball\"\nq = [1, 1, 0, 0]\n",
       "s.toml:10:5: error: q: the length of the quaternion is not 1; scale it: w² + x² + y² + z² = 1"},
      {one_body + "[mechanism.body.joint]\nkind = \"ball\"\nangle = 1\n",
       "s.toml:10:9: error: a ball joint has no 'angle'; write its coordinates as q = […]"},
      {one_body + "[mechanism.body.joint]\nkind = \"prismatic\"\nangle = 1\n",
       "s.toml:10:9: error: a prismatic joint has no 'angle'; its coordinate is a displacement: write 'position'"},
      {pinned + "angle = 1\nq = [1]\n",
       "s.toml:10:9: error: 'angle' gives the initial value a second time; 'q' or 'angle' is given, too"},
      {pinned + "angle = 1\nposition = 1\n",
       "s.toml:11:12: error: 'position' gives the initial value a second time; 'q' or 'angle' is given, too"},
      {pinned + "at = { quat = [0, 0, 0, 0] }\n",
       "s.toml:10:15: error: quat: a quaternion of zeros is not a rotation; the identity is [1, 0, 0, 0]"},
      {pinned + "at = { quat = [1, 0, 0, 0.1] }\n",
       "s.toml:10:15: error: quat: the length of the quaternion is not 1; scale it: w² + x² + y² + z² = 1"},
      {pinned + "at = { quat = [1, 0, 0, 0], rpy = [0, 0, 0] }\n", "s.toml:10:15: error: at: takes 'rpy' or 'quat', not both"},
      {one_body + "[mechanism.body.joint]\nkind = \"ball\"\ndrive = { effort = 1 }\n",
       "s.toml:10:20: error: effort: a ball joint has 3 degrees of freedom: one number is ambiguous; give a list, one effort per "
       "degree of freedom"},
  });
}

TEST_CASE("mechanisms that are not trees are refused") {
  check({
      {pinned + "parent = \"b\"\n[[mechanism.body]]\nname = \"c\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = "
                "\"revolute\"\nparent = \"a\"\n",
       "s.toml:10:10: error: unknown parent 'b'"},
      {pinned + "parent = \"a\"\n", "s.toml:10:10: error: body 'a' is its own parent"},
      {pinned + "parent = \"b\"\n[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = "
                "\"revolute\"\nparent = \"a\"\n",
       "s.toml:10:10: error: the joints form a cycle: 'a' on 'b' on 'a'; a mechanism is a tree: close the loop by a "
       "[[loop]] instead of one of these joints"},
      {pinned + "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\nparent = "
                "\"a\"\n[[mechanism.body]]\nname = \"c\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = "
                "\"revolute\"\nparent = \"bb\"\n",
       "s.toml:23:10: error: unknown parent 'bb'; did you mean 'b'?"},
      {pinned + "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:11:8: error: a second root: body 'b' is joined to the ground, as 'a' on line 5; give it a joint with a parent, or "
       "a separate [[mechanism]]"},
      {pinned + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\nparent = "
                "\"a\"\n",
       "s.toml:11:8: error: duplicate body 'm/a': the name is already used by another on line 5"},
      {one_body + "[mechanism.body.joint]\nname = \"h\"\nkind = \"revolute\"\n[[mechanism.body]]\nname = \"b\"\nmass = "
                  "1\ninertia = 1\n[mechanism.body.joint]\nname = \"h\"\nkind = \"revolute\"\nparent = \"a\"\n",
       "s.toml:16:8: error: duplicate joint 'm/h': the name is already used by another on line 9"},
      {pinned + "[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"z\"\nmass = 1\ninertia = 1\n",
       "s.toml:11:8: error: duplicate mechanism 'm': the name is already used by another on line 3"},
      {pinned + "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\nparent = "
                "\"other/a\"\n",
       "s.toml:16:10: error: unknown parent 'other/a'; a parent is a body of the same mechanism"},
      {head + "root = \"free\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = "
              "\"revolute\"\n",
       "s.toml:4:8: error: root: body 'a' has its own joint to the ground; leave out 'root', or that joint"},
      {head + "root = \"fred\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n",
       "s.toml:4:8: error: root: expected \"fixed\" or \"free\", found 'fred'; did you mean 'free'?"},
      {chain + "[[mechanism.body]]\nname = \"x\"\nmass = 1\n",
       "s.toml:8:1: error: a mechanism is a chain or bodies, not both; give the chain its own [[mechanism]]"},
      {head + "root = \"fixed\"\n[mechanism.chain]\nlinks = 3\nlength = 1\nmass = 1\n",
       "s.toml:4:8: error: root: a chain is joined to the ground by a revolute joint; leave out 'root'; \"free\" removes that "
       "joint"},
      {head + "[mechanism.chain]\nlinks = 0\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found 0"},
      {head + "[mechanism.chain]\nlinks = 1000000000\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found 1000000000"},
      {head + "[mechanism.chain]\nlinks = 1e9\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found 1e+09"},
      {head + "[mechanism.chain]\nlinks = 1e3\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found 1000; write 1000"},
      {head + "[mechanism.chain]\nlinks = \"many\"\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found \"many\""},
      {head + "[mechanism.chain]\nlinks = 2.5\nlength = 1\nmass = 1\n",
       "s.toml:5:9: error: links: expected a whole number from 1 to 1000000, found 2.5"},
      {head + "[mechanism.chain]\nlynks = 3\nlength = 1\nmass = 1\n[[event]]\nat = 1\nbreak = \"m/3\"\n",
       "s.toml:4:1: error: [mechanism.chain] has no 'links'; how many bodies\n"
       "s.toml:5:1: error: unknown key 'lynks' in [mechanism.chain]; did you mean 'links'?"},
      {head + "[mechanism.chain]\nlinks = 3\nlength = -1\nmass = 1\n", "s.toml:6:10: error: length: must be greater than 0"},
      {head + "state = { joints = { \"9\" = 1 } }\n[mechanism.chain]\nlinks = 3\nlength = 1\nmass = 1\n",
       "s.toml:4:28: error: state: there is no joint '9' in this chain; the joints are 1 to 3"},
      {head + "state = { joints = { q = 1 } }\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = "
              "1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:4:26: error: state: there is no joint 'q' in this mechanism"},
      {head + "state = { velocity = { linear = [1, 0, 0] } }\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = "
              "1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:4:22: error: velocity: the root body is not free: its joint gives its velocity; write root = \"free\", or the "
       "joint's start 'v'"},
      {pinned + "parent = 3\n", "s.toml:10:10: error: parent: expected a string, found a number; write \"3\""},
      {pinned + "parent = \"\"\n", "s.toml:10:10: error: parent: expected the name of a body"},
  });
}

TEST_CASE("degrees of freedom that move no mass are refused") {
  check({
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:5:8: error: joint 'm/a': the joint-space mass is singular: degree of freedom 1 of 1 of this revolute joint moves "
       "no mass; "
       "give the bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"},
      {head + "root = \"free\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\n",
       "s.toml:6:8: error: joint 'm/a': the joint-space mass is singular: degree of freedom 4 of 6 of this free joint moves no "
       "mass; give "
       "the bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"},
  });
}

TEST_CASE("impossible limits are refused") {
  check({
      {pinned + "limits = { lower = 1, upper = 0 }\n", "s.toml:10:10: error: limits: 'lower' must be less than 'upper'"},
      {pinned + "limits = { }\n",
       "s.toml:10:10: error: limits: neither 'lower' nor 'upper'; for example limits = { lower = \"-90 deg\", upper = \"90 deg\" "
       "}"},
      {pinned + "limits = { lower = \"1 m\" }\n",
       "s.toml:10:20: error: lower: '1 m' is a length (m), not an angle (rad); for example 0.5236, or \"30 deg\""},
      {pinned + "limits = { upper = [-inf, 2] }\n",
       "s.toml:10:20: error: upper: expected 1 number, found a list of 2; one per degree of freedom or coordinate, in the order "
       "of the joint kind"},
      {pinned + "limits = { lower = nan }\n", "s.toml:10:20: error: lower: must be finite"},
      {pinned + "limits = { upper = 1, restitution = 1.5 }\n",
       "s.toml:10:10: error: limits: a restitution above 1 would create energy; 0 is plastic, 1 elastic"},
      {pinned + "limits = { upper = 1, rest_speed = 0 }\n", "s.toml:10:10: error: limits: 'rest_speed' must be positive"},
      {pinned + "angle = 2\nlimits = { upper = 1 }\n", "s.toml:10:9: error: q: starts beyond its limits"},
      {pinned + "limits = 3\n",
       "s.toml:10:10: error: limits: expected a table, found a number; write limits = { lower = -3, upper = 3 }"},
  });
}
