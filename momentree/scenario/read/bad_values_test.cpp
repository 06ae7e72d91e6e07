#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

TEST_CASE("values of the wrong type, unit or range are refused") {
  check({
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"3 m\"\ninertia = 1\n",
       "s.toml:6:8: error: mass: '3 m' is a length (m), not a mass (kg); for example 0.2, or \"200 g\""},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"3\"\ninertia = 1\n",
       "s.toml:6:8: error: mass: '3' has no unit; write 3 without quotes, or \"3 kg\""},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"1,5 kg\"\ninertia = 1\n",
       "s.toml:6:8: error: mass: '1,5 kg' has a comma in its number; the decimal sign is a point"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"1.0kg\"\ninertia = 1\n",
       "s.toml:6:8: error: mass: '1.0kg' runs number and unit together; write \"1.0 kg\""},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"1 kgs\"\ninertia = 1\n",
       "s.toml:6:8: error: mass: unknown unit 'kgs'; did you mean 'kg'?"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = nan\ninertia = 1\n", "s.toml:6:8: error: mass: must be finite"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = -inf\ninertia = 1\n", "s.toml:6:8: error: mass: must be finite"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = true\ninertia = 1\n",
       "s.toml:6:8: error: mass: expected a mass (kg), found true or false; for example 0.2, or \"200 g\""},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 2026-01-01\ninertia = 1\n",
       "s.toml:6:8: error: mass: expected a mass (kg), found a date or time; for example 0.2, or \"200 g\""},
      {head + "[[mechanism.body]]\nname = 3\nmass = 1\ninertia = 1\n",
       "s.toml:5:8: error: name: expected a string, found a number; write \"3\""},
      {one_body + "com = [0, 1]\n",
       "s.toml:8:7: error: com: expected three numbers, found a list of 2; write x, y and z, as in com = [0, 1, 0]"},
      {one_body + "com = 1\n",
       "s.toml:8:7: error: com: expected three numbers, found a number; write x, y and z, as in com = [1, 0, 0]"},
      {one_body + "com = [0, \"3 kg\", 0]\n",
       "s.toml:8:11: error: com: '3 kg' is a mass (kg), not a length (m); for example 0.5, or \"50 cm\""},
      {pinned + "angle = \"3 m\"\n",
       "s.toml:10:9: error: angle: '3 m' is a length (m), not an angle (rad); for example 0.5236, or \"30 deg\""},
      {pinned + "speed = \"3 rpm/s\"\n",
       "s.toml:10:9: error: speed: '3 rpm/s' is a quantity in s^-2 rad, not an angular speed (rad/s); for example 0.5236, or "
       "\"30 deg/s\""},
      {pinned + "damping = \"1 N s/m\"\n",
       "s.toml:10:11: error: damping: '1 N s/m' is a damping (N s/m), not a rotational damping (N m s/rad); for example 0.1, or "
       "\"0.1 N m s\""},
      {pinned + "at = [0, 0, 0]\n", "s.toml:10:6: error: at: expected a table, found a list; write at = { xyz = [0, 0, 0] }"},
      {head + "state = 3\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n",
       "s.toml:4:9: error: state: expected a table or the name of a file, found a number"},
      {pinned + "[world]\ngravity = 9.81\n",
       "s.toml:11:11: error: gravity: expected three numbers, found a number; write gravity = [0, 0, -9.81]"},
      {pinned + "[integrate]\nstep = \"1 m\"\n",
       "s.toml:11:8: error: step: '1 m' is a length (m), not a time (s); for example 2, or \"2 s\""},
  });
}

TEST_CASE("impossible bodies are refused") {
  check({
      {head + "[[mechanism.body]]\nname = \"a\"\ninertia = 1\n",
       "s.toml:4:1: error: [[mechanism.body]] has no 'mass'; in kg, or a string such as \"10 g\"; or density = \"2700 kg/m^3\" "
       "and a shape"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = -1\ninertia = 1\n", "s.toml:6:8: error: mass: must not be negative"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"0 g\"\ninertia = 1\n",
       "s.toml:7:11: error: inertia: a body without mass has none; give a mass, or an inertia of 0"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1]\n",
       "s.toml:7:11: error: inertia: expected 1, 3 or 6 numbers, found a list of 2; 1 number for all, 3 for xx, yy, zz, or 6 for "
       "xx, yy, zz, xy, xz, yz"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 3]\n",
       "s.toml:7:11: error: inertia: the largest principal moment is more than the sum of the others, which no body has; it is "
       "meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, -1]\n",
       "s.toml:7:11: error: inertia: no body has a negative principal moment; the order is xx, yy, zz, xy, xz, yz, about the "
       "centre of mass"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1, 2, 0, 0]\n",
       "s.toml:7:11: error: inertia: no body has a negative principal moment; the order is xx, yy, zz, xy, xz, yz, about the "
       "centre of mass"},
      {head + "[[mechanism.body]]\nmass = 1\ninertia = 1\n",
       "s.toml:4:1: error: [[mechanism.body]] has no 'name'; for example name = \"arm\""},
      {head + "[[mechanism.body]]\nname = \"\"\nmass = 1\ninertia = 1\n",
       "s.toml:5:8: error: name: a body cannot be named '': it is empty"},
      {head + "[[mechanism.body]]\nname = \"a/b\"\nmass = 1\ninertia = 1\n",
       "s.toml:5:8: error: name: a body cannot be named 'a/b': it has a character that is not allowed; a name has no / , \" * "
       "and no control characters"},
      {head + "[[mechanism.body]]\nname = \"a\\u001b\"\nmass = 1\ninertia = 1\n",
       "s.toml:5:8: error: name: a body cannot be named 'a\\x1b': it has an invisible character; a name has no control "
       "characters, direction marks and the like"},
      {head + "[[mechanism.body]]\nname = \"ground\"\nmass = 1\ninertia = 1\n",
       "s.toml:5:8: error: name: a body cannot be named 'ground': it means the ground"},
      {one_body + "shape = { box = [1, 0, 1] }\n", "s.toml:8:17: error: box: its three edges must be greater than 0"},
      {one_body + "shape = { box = [1, 1, 1], sphere = 1 }\n",
       "s.toml:8:9: error: a shape is one of box, sphere, cylinder, capsule, ellipsoid and mesh; make the others further entries "
       "of a list"},
      {one_body + "shape = {}\n",
       "s.toml:8:9: error: a shape is one of box, sphere, cylinder, capsule, ellipsoid and mesh; for example { sphere = 0.1 }"},
      {one_body + "collision = {}\n",
       "s.toml:8:13: error: a shape is one of box, sphere, cylinder, capsule, ellipsoid and mesh; for example { sphere = 0.1 }"},
      {one_body + "collision = []\n",
       "s.toml:8:13: error: collision: the list has no shape; leave it out, or write collision = \"none\""},
      {one_body + "shape = []\n", "s.toml:8:9: error: shape: the list has no shape; leave it out"},
      {one_body + "collision = [{ sphere = 1 }, { at = { xyz = [1, 0, 0] } }]\n",
       "s.toml:8:30: error: a shape is one of box, sphere, cylinder, capsule, ellipsoid and mesh; for example { sphere = 0.1 }"},
      {one_body + "shape = { mesh = \"../../etc/passwd\" }\n",
       "s.toml:8:18: error: mesh: '../../etc/passwd' is not a file in the scenario's folder or below it; copy it there"},
      {one_body + "shape = { mesh = \"/dev/zero\" }\n",
       "s.toml:8:18: error: mesh: '/dev/zero' is not a file in the scenario's folder or below it; copy it there"},
      {one_body + "shape = { sphere = 1, colour = \"rde\" }\n",
       "s.toml:8:32: error: colour: 'rde' is not a colour; did you mean 'red'?"},
      {one_body + "shape = { cylinder = { radius = 1 } }\n", "s.toml:8:22: error: cylinder has no 'length'"},
      {one_body + "shape = { cylinder = { radius = 1, length = 0 } }\n",
       "s.toml:8:45: error: length: must be greater than 0; a disc is a thin { ellipsoid = [0.3, 0.3, 1e-3] }"},
      {one_body + "shape = { capsule = { radius = 1, length = 0 } }\n",
       "s.toml:8:44: error: length: must be greater than 0; without a length it is a sphere"},
      {one_body + "shape = [{ sphere = 1 }, { sphere = 0 }]\n", "s.toml:8:37: error: sphere: its radius must be greater than 0"},
      {one_body + "shape = { sphere = 1, scale = 2 }\n",
       "s.toml:8:31: error: scale: only a mesh is scaled; give the shape its size"},
      {one_body + "shape = { mesh = \"a.stl\", scale = [1, 0, 1] }\n", "s.toml:8:35: error: scale: must not be 0"},
      {"format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n" + one_body.substr(head.size()),
       "s.toml:2:1: error: roots: 1 bodies of mechanism 'm' are joined to the ground, not 2"},
      {"format = 1\n[[mechanism]]\nname = \"m\"\nroots = 0\n" + one_body.substr(head.size()),
       "s.toml:4:9: error: roots: expected a whole number from 1 to 1000000, found 0"},
      {"format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n" + chain.substr(head.size()),
       "s.toml:4:9: error: roots: this key is for a mechanism with [[mechanism.body]] tables"},
  });
}
