// Joint parameters other than kind and geometry.
#include <algorithm>

#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

namespace {

// One value for all DoFs, or one for each.
template <class Value>
std::string per_dof(Choices& choose, int dofs, Value value) {
  if (dofs == 1 || choose.chance(0.5)) return value();
  std::string list = "[" + value();
  for (int i = 1; i < dofs; ++i) list += ", " + value();
  return list + "]";
}

template <class Value>
std::string each_dof(int dofs, Value value) {
  if (dofs == 1) return value();
  std::string list = "[" + value();
  for (int i = 1; i < dofs; ++i) list += ", " + value();
  return list + "]";
}

std::string random_limits(Draft& draft, const KindInfo& kind) {
  Choices& choose = draft.choose;
  Entries entries;
  const bool low = choose.chance(0.7);
  if (low) entries.emplace_back("lower", per_dof(choose, kind.nv, [&] { return choose.number(-1.2, -0.3); }));
  if (!low || choose.chance(0.6))
    entries.emplace_back("upper", per_dof(choose, kind.nv, [&] { return choose.chance(0.1) ? "inf" : choose.number(0.3, 1.2); }));
  if (choose.chance(0.3)) {
    entries.emplace_back("stiffness", per_dof(choose, kind.nv, [&] { return choose.magnitude(0, 2); }));
    if (choose.chance(0.6)) entries.emplace_back("damping", per_dof(choose, kind.nv, [&] { return choose.magnitude(-2, 0); }));
    return braces(entries);
  }
  if (choose.chance(0.6))
    entries.emplace_back("restitution", per_dof(choose, kind.nv, [&] { return choose.word({"0", "0.3", "0.5", "0.8", "1"}); }));
  if (choose.chance(0.3)) entries.emplace_back("rest_speed", choose.magnitude(-5, -1));
  return braces(entries);
}

std::string random_drive(Draft& draft, const KindInfo& kind, bool may_move) {
  Choices& choose = draft.choose;
  const bool rates = kind.nq == kind.nv, one = kind.nq == 1 && kind.nv == 1;
  if (may_move && one && choose.chance(0.4)) {
    if (choose.chance(0.4)) return "{ motion = { rate = " + choose.number(-2, 2) + " } }";
    std::string motion = random_signal(draft, 0.4);
    if (motion.starts_with("{ table") && choose.chance(0.5)) motion = motion.substr(0, motion.size() - 2) + ", ends = \"free\" }";
    return "{ motion = " + motion + " }";
  }
  Entries entries;
  const bool pd = rates && choose.chance(0.4);
  if (!pd || choose.chance(0.3)) entries.emplace_back("effort", each_dof(kind.nv, [&] { return random_signal(draft, 3); }));
  if (!pd) return braces(entries);
  Entries control{{"kp", per_dof(choose, kind.nv, [&] { return choose.magnitude(-1, 1); })}};
  if (choose.chance(0.7)) control.emplace_back("kd", per_dof(choose, kind.nv, [&] { return choose.magnitude(-2, 0); }));
  if (choose.chance(0.6)) control.emplace_back("target", each_dof(kind.nv, [&] { return random_signal(draft, 1); }));
  if (choose.chance(0.3)) control.emplace_back("target_speed", each_dof(kind.nv, [&] { return random_signal(draft, 1); }));
  if (choose.chance(0.3)) control.emplace_back("max_effort", per_dof(choose, kind.nv, [&] { return choose.magnitude(-1, 1); }));
  entries.emplace_back("pd", braces(control));
  return braces(entries);
}

}  // namespace

std::string lines(const Entries& entries) {
  std::string text;
  for (const auto& [key, value] : entries) text += key + " = " + value + "\n";
  return text;
}

bool has(const Entries& entries, const char* key) {
  return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.first == key; });
}

std::string braces(const Entries& entries) {
  std::string text;
  for (const auto& [key, value] : entries) text += (text.empty() ? "{ " : ", ") + key + " = " + value;
  return text.empty() ? "{}" : text + " }";
}

std::string random_coordinates(Choices& choose, const KindInfo& kind, double size) {
  std::string list;
  for (int i = 0; i < kind.nq; ++i) {
    list += list.empty() ? "" : ", ";
    if (kind.q_units[i] == 'n') {
      list += choose.word({"1, 0, 0, 0", "0.8, 0.6, 0, 0", "0.5, 0.5, -0.5, 0.5", "-0.6, 0, 0.8, 0", "0, 0, 0.6, 0.8"});
      i += 3;
    } else {
      list += choose.number(-size, size);
    }
  }
  return kind.nq == 1 ? list : "[" + list + "]";
}

std::string random_velocities(Choices& choose, const KindInfo& kind) {
  return each_dof(kind.nv, [&] { return choose.number(-2, 2); });
}

std::string random_signal(Draft& draft, double size) {
  Choices& choose = draft.choose;
  const int what = choose.integer(0, 3);
  if (what == 0) return choose.number(-size, size);
  if (what == 1) {
    const Entries sine{{"amplitude", choose.number(-size, size)},
                       {"frequency", choose.number(0.1, 2)},
                       {"phase", choose.number(-3, 3)},
                       {"offset", choose.number(-size, size)}};
    return "{ sine = " + braces(sine) + " }";
  }
  if (what == 2) return "{ rate = " + choose.number(-size, size) + ", offset = " + choose.number(-size, size) + " }";
  std::string table;
  double time = choose.integer(-1, 2) * 0.05;
  for (int k = choose.integer(2, 4); k > 0; --k) {
    char at[32];
    std::snprintf(at, sizeof at, "%.3g", time);
    table += (table.empty() ? "[" : ", [") + std::string(at) + ", " + choose.number(-size, size) + "]";
    time += 0.05 * choose.integer(1, 6);
  }
  return "{ table = [" + table + "] }";
}

Entries random_parameters(Draft& draft, const KindInfo& kind, bool may_move) {
  Choices& choose = draft.choose;
  Entries all;
  if (kind.nv == 0) {
    if (!draft.certain && choose.chance(0.15)) all.emplace_back("strength", "{ force = " + choose.magnitude(0, 2) + " }");
    return all;
  }
  const bool rates = kind.nq == kind.nv;
  if (choose.chance(0.35))
    all.emplace_back("damping", per_dof(choose, kind.nv, [&] { return choose.magnitude(-3, draft.heavy ? 2 : -1); }));
  if (choose.chance(0.2)) {
    all.emplace_back("stiffness", per_dof(choose, kind.nv, [&] { return choose.magnitude(-1, 1); }));
    if (choose.chance(0.5)) all.emplace_back("rest", random_coordinates(choose, kind));
  }
  if (choose.chance(0.15)) all.emplace_back("armature", per_dof(choose, kind.nv, [&] { return choose.magnitude(-3, -1); }));
  if (choose.chance(0.15)) {
    const std::string coulomb = per_dof(choose, kind.nv, [&] { return choose.magnitude(-2, 0); });
    all.emplace_back("friction", "{ coulomb = " + coulomb + ", speed = " + choose.magnitude(-1, 0) + " }");
  }
  if (!draft.certain && choose.chance(0.1)) {
    const bool force = choose.chance(0.6);
    all.emplace_back("strength",
                     std::string("{ ") + (force ? "force" : "torque") + " = " + choose.magnitude(force ? 0 : -1, 2) + " }");
  }
  bool moves = false;
  if (choose.chance(0.3)) {
    all.emplace_back("drive", random_drive(draft, kind, may_move));
    moves = all.back().second.starts_with("{ motion");
  }
  if (!moves && rates && choose.chance(0.3)) all.emplace_back("limits", random_limits(draft, kind));
  return all;
}

}  // namespace momentree::fuzz
