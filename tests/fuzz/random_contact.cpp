// Mixtures: what touches, cables, and joints that close loops.
#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

std::string random_collision(Choices& choose) {
  const auto size = [&] { return choose.number(0.03, 0.15); };
  const auto rod = [&] { return braces({{"radius", size()}, {"length", size()}}); };
  const auto solid = [&] {
    Entries shape;
    const auto three = [&] { return "[" + size() + ", " + size() + ", " + size() + "]"; };
    switch (choose.integer(0, 5)) {
      case 0: shape = {{"sphere", size()}}; break;
      case 1: shape = {{"capsule", rod()}}; break;
      case 2: shape = {{"cylinder", rod()}}; break;
      case 3: shape = {{"mesh", quoted("wedge.obj")}, {"scale", size()}}; break;
      case 4: shape = {{"ellipsoid", three()}}; break;
      default: shape = {{"box", three()}};
    }
    if (choose.chance(0.5)) shape.emplace_back("at", braces({{"xyz", choose.vector(0.1)}, {"rpy", choose.vector(1)}}));
    return braces(shape);
  };
  const std::string one = solid();
  std::string all = "collision = " + (choose.chance(0.2) ? "[" + one + ", " + solid() + "]" : one) + "\n";
  if (choose.chance(0.1)) all += "belt = " + braces({{"axis", choose.vector(1)}, {"speed", choose.number(-1, 1)}}) + "\n";
  return all;
}

Entries random_contact_law(Choices& choose) {
  Entries law;
  if (choose.chance(0.7))
    law.emplace_back("friction", choose.word({"0", "0.1", "0.3", "0.8", "{ static = 0.5, kinetic = 0.3 }"}));
  if (choose.chance(0.5)) law.emplace_back("restitution", choose.word({"0", "0.2", "0.5", "0.9"}));
  return law;
}

std::string touching_pair(Draft& draft) {
  Choices& choose = draft.choose;
  const std::string one = choose.pick(draft.solids), other = choose.pick(draft.solids);
  return "[" + quoted(one) + ", " + quoted(other == one || choose.chance(0.5) ? "floor" : other) + "]";
}

void add_contacts(Draft& draft) {
  Choices& choose = draft.choose;
  for (int left = draft.solids.empty() ? 0 : choose.integer(0, 2); left > 0; --left) {
    Entries all;
    if (choose.chance(0.7)) all.emplace_back("between", touching_pair(draft));
    if (all.empty() || choose.chance(0.8))
      for (auto& entry : random_contact_law(choose)) all.push_back(std::move(entry));
    else
      all.emplace_back("off", "true");
    draft.text += "\n[[contact]]\n" + lines(all);
  }
}

void add_cables(Draft& draft) {
  Choices& choose = draft.choose;
  int number = 0;
  for (int left = choose.chance(0.4) ? choose.integer(1, 2) : 0; left > 0; --left) {
    const std::string from = choose.pick(draft.bodies), to = choose.chance(0.4) ? "ground" : choose.pick(draft.bodies);
    if (from == to) continue;
    const std::string name = "cable " + std::to_string(++number);
    const auto end = [&](const std::string& body) { return braces({{"body", quoted(body)}, {"point", choose.vector(0.2)}}); };
    Entries all{{"name", quoted(name)}, {"from", end(from)}, {"to", end(to)}};
    if (choose.chance(0.2)) all.emplace_back("length", choose.number(1, 3));
    if (choose.chance(0.5)) all.emplace_back("restitution", choose.word({"0.3", "0.8"}));
    if (!draft.certain && choose.chance(0.3)) all.emplace_back("strength", choose.magnitude(0, 2));
    draft.text += "\n[[cable]]\n" + lines(all);
    if (choose.chance(0.3))
      draft.text += "\n[[event]]\n" + lines({{"at", choose.number(0, draft.until)}, {"break", quoted(name)}});
  }
}

void add_loops(Draft& draft) {
  Choices& choose = draft.choose;
  for (int left = choose.chance(0.4) ? choose.integer(1, 2) : 0, number = 1; left > 0; --left, ++number) {
    const std::string body = choose.pick(draft.bodies), to = choose.chance(0.4) ? "ground" : choose.pick(draft.bodies);
    const KindInfo& kind = choose.pick(all_kinds());
    if (body == to || kind.kind == Kind::free || kind.nv == 0) continue;
    const std::string name = "loop " + std::to_string(number);
    Entries all{{"name", quoted(name)}, {"body", quoted(body)}, {"to", quoted(to)}, {"kind", quoted(kind.name)}};
    for (auto& entry : random_geometry(choose, kind)) all.push_back(std::move(entry));
    all.emplace_back("at", braces({{"xyz", choose.vector(0.3)}}));
    for (auto& entry : random_parameters(draft, kind, false)) all.push_back(std::move(entry));
    draft.text += "\n[[loop]]\n" + lines(all);
    draft.joints.push_back({name, body, &kind});
    draft.joints.back().coupled = true;  // it has no coupling, and may keep its kind
  }
}

}  // namespace momentree::fuzz
