// Piles: bodies that stand, lean and fall on each other, some of them hinged, hung or held.
#include <cstdlib>

#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

namespace {

constexpr double tall[] = {0.06, 0.1, 0.14, 0.2};  // heights: sums of them are flush

std::string decimal(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", x);
  return text;
}

// A solid of that height, and its half width.
std::string standing_solid(Choices& choose, double height, double& half) {
  const double wide = choose.integer(3, 12) * 0.02;
  half = wide / 2;
  const std::string h = decimal(height), w = decimal(wide), r = decimal(wide / 2);
  switch (choose.integer(0, 7)) {
    case 0: return "{ cylinder = { radius = " + r + ", length = " + h + " } }";
    case 1: half = height / 2; return "{ sphere = " + decimal(height / 2) + " }";
    case 2: return "{ ellipsoid = [" + w + ", " + decimal(wide / 2) + ", " + decimal(height / 2) + "] }";
    case 3:
      return "{ capsule = { radius = " + decimal(height / 2) + ", length = " + w + " }, at = { rpy = [\"90 deg\", 0, 0] } }";
    case 4:
      return "{ cylinder = { radius = " + decimal(height / 2) + ", length = " + w + " }, at = { rpy = [\"90 deg\", 0, 0] } }";
    default: return "{ box = [" + w + ", " + decimal(choose.integer(3, 12) * 0.02) + ", " + h + "] }";
  }
}

}  // namespace

std::string random_pile(Choices& choose) {
  Draft draft{choose};
  draft.mixed = true;
  draft.until = 0.4;
  draft.text =
      "format = 1\n[world]\ngravity = " + choose.word({"[0, 0, -9.81]", "[0, 0, -9.81]", "[1, 0, -9.7]", "[2.5, 1, -9]"}) + "\n";
  const bool elastic = choose.chance(0.3);
  const auto law = [&] {
    Entries all{{"friction", choose.word({"0.5", "0.2", "0.8", "0", "1.5",
                                          "{ static = 0.6, kinetic = 0.4, torsional = 0.003, rolling = 0.002 }"})}};
    if (elastic) all.emplace_back("restitution", choose.word({"0", "0.3", "0.7"}));
    return all;
  };
  Entries floor = law();
  floor.emplace_back("normal", "[0, 0, 1]");
  draft.text += "floor = " + braces(floor) + "\n[[contact]]\n" + lines(law());
  draft.text += "[integrate]\n" + lines({{"method", quoted(choose.word({"rk4", "dop853", "dop853", "dopri5"}))},
                                         {"until", "0.4"},
                                         {"step", choose.word({"1e-3", "2e-3", "4e-3"})},
                                         {"resolve", "true"}});
  draft.text += "[output]\nevery = 0.02\n";
  const bool flush = choose.chance(0.5);
  const int columns = choose.integer(1, 2);  // of few bodies: many points are slow to locate
  for (int column = 0; column < columns; ++column) {
    double z = 0;
    std::string below;  // a body of the same mechanism
    for (int left = choose.integer(1, 4 - columns), k = 1; left > 0; --left, ++k) {
      const double height = tall[choose.integer(0, 3)];
      double half = 0;
      const std::string solid = standing_solid(choose, height, half);
      const double gap = flush ? 0 : choose.integer(0, 3) * 0.02, x = 0.6 * column + choose.integer(-2, 2) * 0.02;
      const std::string body = "b" + std::to_string(k), mass = choose.magnitude(-1, 0);
      const double unit = std::atof(mass.c_str()) * (height * height + half * half);
      const bool joined = !below.empty() && choose.chance(0.25);
      if (!joined) {
        const std::string name = "m" + std::to_string(draft.mechanisms.size() + 1);
        draft.mechanisms.push_back(name), below.clear();
        draft.text += "\n[[mechanism]]\nname = " + quoted(name) + "\n";
        const bool held = k == 1 && choose.chance(0.1);
        if (!held) draft.text += "root = \"free\"\n";
        draft.floats.push_back(!held);
        draft.text += "pose = { xyz = [" + decimal(x) + ", 0, " + decimal(z + gap + height / 2) + "]" +
                      (flush ? "" : ", rpy = " + choose.vector(0.3)) + " }\n";
        if (!flush && choose.chance(0.5))
          draft.text += "state = { velocity = { linear = " + choose.vector(1) + ", angular = " + choose.vector(2) + " } }\n";
        draft.joints.push_back({name + "/" + body, name + "/" + body, &info(held ? Kind::weld : Kind::free), true});
      }
      const std::string full = draft.mechanisms.back() + "/" + body;
      draft.text +=
          "[[mechanism.body]]\nname = " + quoted(body) + "\n" +
          lines({{"mass", mass},
                 {"inertia", "[" + decimal(0.3 * unit) + ", " + decimal(0.25 * unit) + ", " + decimal(0.2 * unit) + "]"}}) +
          "collision = " + solid + "\n";
      if (joined) {
        const KindInfo& kind = info(choose.chance(0.5) ? Kind::revolute : choose.chance(0.5) ? Kind::prismatic : Kind::ball);
        draft.text += "[mechanism.body.joint]\nkind = " + quoted(kind.name) + "\nparent = " + quoted(below) + "\n";
        if (kind.axis) draft.text += "axis = [0, 1, 0]\n";
        draft.text += "at = { xyz = [" + decimal(2.2 * half + 0.1) + ", 0, 0] }\n";
        if (choose.chance(0.4) && kind.nv == 1) draft.text += "limits = { lower = -0.3, upper = 0.3 }\n";
        draft.joints.push_back({full, full, &kind});
      }
      draft.bodies.push_back(full), draft.solids.push_back(full);
      below = body;
      if (!joined) z += gap + height;
    }
  }
  add_cables(draft);
  for (int left = choose.chance(0.3) ? choose.integer(1, 2) : 0; left > 0; --left) add_event(draft);
  return draft.text;
}

}  // namespace momentree::fuzz
