// Mechanisms: trees of bodies and chains, with couplings and forces.
#include <cstdlib>

#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

namespace {

std::string placement(Choices& choose, double size) {
  Entries entries;
  if (choose.chance(0.8)) entries.emplace_back("xyz", choose.vector(size));
  if (choose.chance(0.4)) entries.emplace_back("rpy", choose.vector(3));
  return braces(entries);
}

// An inertia that a cloud of masses can have; a rod; a point.
std::string inertia(Choices& choose, double mass, bool rod) {
  const double size = choose.integer(1, 6) * 0.05, unit = mass * size * size;
  const auto text = [](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.4g", x);
    return std::string(buffer);
  };
  if (rod) return "[0, " + text(unit) + ", " + text(unit) + "]";
  if (choose.chance(0.25)) return text(unit);
  const int a = choose.integer(3, 10), b = choose.integer(3, 10), c = choose.integer(3, 10);
  std::string list = text(0.1 * unit * (b + c)) + ", " + text(0.1 * unit * (a + c)) + ", " + text(0.1 * unit * (a + b));
  if (choose.chance(0.3)) list += ", " + text(0.02 * unit) + ", " + text(-0.03 * unit) + ", " + text(0.01 * unit);
  return "[" + list + "]";
}

std::string masses(Choices& choose, bool free) {
  const bool extreme = choose.chance(0.05), thin = choose.chance(free ? 0 : 0.06), point = thin && choose.chance(0.3);
  const std::string mass = extreme ? choose.word({"1e-3", "500"}) : choose.magnitude(-1, 0);
  Entries entries{{"mass", mass}};
  if (point || choose.chance(0.7)) entries.emplace_back("com", choose.vector(0.3));
  if (!point) entries.emplace_back("inertia", inertia(choose, std::atof(mass.c_str()), thin));
  return lines(entries);
}

const KindInfo& random_kind(Choices& choose) {
  if (choose.chance(0.4)) return info(Kind::revolute);
  return choose.pick(all_kinds());
}

}  // namespace

Entries random_geometry(Choices& choose, const KindInfo& kind) {
  Entries entries;
  if (kind.axis2) {
    entries.emplace_back("axis", "[1, 0, " + choose.number(-0.5, 0.5) + "]");
    entries.emplace_back("axis2", "[" + choose.number(-0.5, 0.5) + ", 1, 0]");
  } else if (kind.axis) {
    entries.emplace_back("axis", choose.axis());
  }
  if (kind.pitch) entries.emplace_back("pitch", choose.number(-0.5, 0.5));
  return entries;
}

namespace {

// Where a mechanism starts: above the floor if there is one.
std::string start_pose(Draft& draft) {
  Choices& choose = draft.choose;
  if (!draft.mixed) return placement(choose, 1);
  const std::string x = choose.number(-1, 1), y = choose.number(-1, 1), z = choose.number(0, 0.5);
  return "{ xyz = [" + x + ", " + y + ", " + z + "]" + (choose.chance(0.4) ? ", rpy = " + choose.vector(3) : "") + " }";
}

void add_joint(Draft& draft, const std::string& mechanism, const std::string& body, const std::string& parent) {
  Choices& choose = draft.choose;
  const KindInfo& kind = random_kind(choose);
  const bool own_name = choose.chance(0.3);
  const std::string name = own_name ? "j" + body : body;
  draft.text += "[mechanism.body.joint]\n";
  if (own_name) draft.text += "name = " + quoted(name) + "\n";
  draft.text += "kind = " + quoted(kind.name) + "\n" + lines(random_geometry(choose, kind));
  if (!parent.empty()) draft.text += "parent = " + quoted(parent) + "\n";
  if (choose.chance(0.8)) draft.text += "at = " + placement(choose, 0.5) + "\n";
  if (choose.chance(0.25)) draft.text += "child_at = " + placement(choose, 0.3) + "\n";
  const Entries parameters = random_parameters(draft, kind, !draft.mixed);
  bool moves = false;
  for (const auto& [key, value] : parameters) moves = moves || value.starts_with("{ motion");
  if (kind.nv > 0 && !moves) {
    const double size = has(parameters, "limits") ? 0.29 : 1;
    if (choose.chance(0.5)) draft.text += "q = " + random_coordinates(choose, kind, size) + "\n";
    if (choose.chance(0.6)) draft.text += "v = " + random_velocities(choose, kind) + "\n";
  }
  draft.text += lines(parameters);
  draft.joints.push_back(
      {mechanism + "/" + name, mechanism + "/" + body, &kind, parent.empty(), moves, has(parameters, "strength")});
}

int add_chain(Draft& draft, const std::string& name, int most) {
  Choices& choose = draft.choose;
  const int links = choose.integer(2, std::min(most, 5));
  const bool free = choose.chance(0.3);
  if (free) draft.text += "root = \"free\"\n";
  if (draft.mixed || choose.chance(0.5)) draft.text += "pose = " + start_pose(draft) + "\n";
  if (choose.chance(0.5))
    draft.text += "state = { joints = { " + std::to_string(links) + " = { speed = " + choose.number(-3, 3) + " } } }\n";
  draft.text += "[mechanism.chain]\n";
  draft.text += lines({{"links", std::to_string(links)},
                       {"length", choose.number(0.1, 0.5)},
                       {"mass", choose.magnitude(-1, 0)},
                       {"inertia", choose.magnitude(-3, -1)},
                       {"axis", choose.axis()}});
  if (draft.mixed && choose.chance(0.5)) draft.text += "radius = 0.05\n";
  const Entries parameters = random_parameters(draft, info(Kind::revolute), false);
  draft.text += lines(parameters);
  const bool limited = has(parameters, "limits");
  if (choose.chance(0.7)) draft.text += "angle = " + choose.number(limited ? -0.29 : -1, limited ? 0.29 : 1) + "\n";
  if (!limited && choose.chance(0.3)) draft.text += "angle_growth = true\n";
  for (int k = 1; k <= links; ++k) {
    const std::string link = name + "/" + std::to_string(k);
    draft.bodies.push_back(link);
    const bool strong = has(parameters, "strength") && !(free && k == 1);
    draft.joints.push_back({link, link, &info(free && k == 1 ? Kind::free : Kind::revolute), k == 1, false, strong});
  }
  draft.floats.push_back(free);
  return links;
}

}  // namespace

int add_mechanism(Draft& draft, int most) {
  Choices& choose = draft.choose;
  const std::string name = "m" + std::to_string(draft.mechanisms.size() + 1);
  draft.mechanisms.push_back(name);
  draft.text += "\n[[mechanism]]\nname = " + quoted(name) + "\n";
  if (most > 1 && choose.chance(0.2)) return add_chain(draft, name, most);
  const int count = choose.integer(1, most), held = choose.integer(0, draft.mixed ? 3 : 2);  // by a joint, fixed, else free
  const bool two = held == 0 && count > 1 && choose.chance(0.1);
  if (draft.mixed || choose.chance(0.6)) draft.text += "pose = " + start_pose(draft) + "\n";
  if (two) draft.text += "roots = 2\n";
  if (held == 1 && choose.chance(0.5)) draft.text += "root = \"fixed\"\n";
  if (held >= 2) {
    draft.text += "root = \"free\"\n";
    if (choose.chance(0.7))
      draft.text += "state = { velocity = { linear = " + choose.vector(1) + ", angular = " + choose.vector(2) + " } }\n";
  }
  draft.floats.push_back(held >= 2);
  for (int k = 1; k <= count; ++k) {
    const std::string body = "b" + std::to_string(k);
    draft.text += "[[mechanism.body]]\nname = " + quoted(body) + "\n" + masses(choose, k == 1 && held >= 2);
    if (draft.mixed && choose.chance(0.6)) {
      draft.text += random_collision(choose);
      draft.solids.push_back(name + "/" + body);
    }
    draft.bodies.push_back(name + "/" + body);
    if (k == 1 && held > 0) {
      draft.joints.push_back({name + "/" + body, name + "/" + body, &info(held == 1 ? Kind::weld : Kind::free), true});
      continue;
    }
    const bool root = k == 1 || (two && k == 2);
    add_joint(draft, name, body, root ? "" : "b" + std::to_string(choose.chance(0.6) ? k - 1 : choose.integer(1, k - 1)));
  }
  return count;
}

void add_couplings(Draft& draft) {
  Choices& choose = draft.choose;
  std::vector<std::size_t> one;
  for (std::size_t j = 0; j < draft.joints.size(); ++j)
    if (draft.joints[j].kind->nv == 1 && !draft.joints[j].moves) one.push_back(j);
  for (int left = choose.chance(0.25) ? choose.integer(1, 2) : 0; left > 0 && one.size() > 1; --left) {
    const std::size_t a = choose.pick(one), b = choose.pick(one);
    if (a == b) continue;
    draft.joints[a].coupled = draft.joints[b].coupled = true;
    Entries entries{{"joint", quoted(draft.joints[a].name)}, {"follows", quoted(draft.joints[b].name)}};
    if (choose.chance(0.7)) entries.emplace_back("multiplier", choose.number(-2, 2));
    if (choose.chance(0.5)) entries.emplace_back("offset", choose.number(-1, 1));
    if (!draft.mixed || choose.chance(0.4)) {
      entries.emplace_back("stiffness", choose.magnitude(-1, 1));
      if (choose.chance(0.5)) entries.emplace_back("damping", choose.magnitude(-2, -1));
    }
    draft.text += "\n[[coupling]]\n" + lines(entries);
  }
}

void add_forces(Draft& draft) {
  Choices& choose = draft.choose;
  for (int left = choose.chance(0.4) ? choose.integer(1, 2) : 0; left > 0; --left) {
    Entries entries;
    entries.emplace_back("body", quoted(choose.chance(0.2) ? choose.pick(draft.mechanisms) + "/*" : choose.pick(draft.bodies)));
    if (choose.chance(0.5)) entries.emplace_back("point", choose.vector(0.4));
    const auto three = [&](double size) {
      const std::string x = random_signal(draft, size), y = choose.chance(0.5) ? random_signal(draft, size) : "0";
      return "[" + x + ", " + y + ", " + choose.number(-size, size) + "]";
    };
    const int what = choose.integer(0, 3);
    if (what == 0 || what == 3) entries.emplace_back("force", three(3));
    if (what == 1) entries.emplace_back("torque", three(0.5));
    if (choose.chance(0.4)) entries.emplace_back("axes", choose.word({"\"body\"", "\"world\""}));
    if (what > 1) {
      Entries drag{{"linear", choose.magnitude(-2, -1)}};
      if (choose.chance(0.5)) drag.emplace_back("quadratic", choose.magnitude(-2, -1));
      if (drag.size() > 1 && choose.chance(0.5)) drag.emplace_back("area", choose.magnitude(-1, 0));
      entries.emplace_back("drag", braces(drag));
    }
    draft.text += "\n[[force]]\n" + lines(entries);
  }
}

}  // namespace momentree::fuzz
