// Events: their triggers and actions.
#include <cstdio>

#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

namespace {

using Joint = Draft::DraftJoint;

std::string in_braces(const char* key, const std::string& value) { return braces({{key, value}}); }

// A joint for an action, usually one that no event has changed yet. `made`: may also be a joint that events make.
Joint& some_joint(
    Draft& draft, bool made, bool (*fits)(const Joint&) = [](const Joint&) { return true; }) {
  std::vector<std::size_t> good;
  for (std::size_t j = 0; j < draft.joints.size(); ++j) {
    const Joint& joint = draft.joints[j];
    if ((made || !joint.made) && !joint.decided && fits(joint)) good.push_back(j);
  }
  const int last = static_cast<int>(draft.joints.size()) - 1;
  if (good.empty() || (!draft.certain && draft.choose.chance(0.1)))
    return draft.joints[static_cast<std::size_t>(draft.choose.integer(0, last))];
  return draft.joints[draft.choose.pick(good)];
}

bool has_dofs(const Joint& joint) { return joint.kind->nv > 0; }

// A name, or a wildcard for several joints or bodies.
struct Named {
  std::string joint, body;
};
Named names(Draft& draft, const Joint& joint) {
  if (!draft.choose.chance(0.1)) return {joint.name, joint.child};
  const std::string all = draft.choose.pick(draft.mechanisms) + "/*";
  return {all, all};
}

std::string dofs(Draft& draft, const Joint& joint, const std::string& name) {
  if (joint.kind->nv < 2 || name != joint.name || draft.choose.chance(0.5)) return quoted(name);
  const int first = draft.choose.integer(0, joint.kind->nv - 1), last = draft.choose.integer(first, joint.kind->nv - 1);
  std::string list = std::to_string(first);
  if (last > first) list += ", " + std::to_string(last);
  return braces({{"joint", quoted(name)}, {"freedoms", "[" + list + "]"}});
}

Entries new_joint(Draft& draft, const KindInfo& kind, bool axes) {
  Choices& choose = draft.choose;
  Entries all{{"kind", quoted(kind.name)}};
  if (kind.axis && axes) all.emplace_back("axis", kind.axis2 ? "[1, 0, 0]" : choose.axis());
  if (kind.axis2 && axes) all.emplace_back("axis2", "[0, 1, 0.2]");
  if (kind.pitch) all.emplace_back("pitch", choose.number(-0.5, 0.5));
  for (auto& entry : random_parameters(draft, kind, false)) all.push_back(std::move(entry));
  return all;
}

std::string change(Draft& draft, const Joint& joint, const std::string& name) {
  const KindInfo& kind = draft.choose.pick(all_kinds());
  const bool known = (joint.kind->axis || !kind.axis) && (joint.kind->axis2 || !kind.axis2);
  Entries all = new_joint(draft, kind, !known || draft.choose.chance(0.5));
  all.emplace(all.begin(), "joint", quoted(name));
  return braces(all);
}

std::string set(Draft& draft, const Joint& joint, const std::string& name) {
  Choices& choose = draft.choose;
  Entries all{{"joint", quoted(name)}};
  if (name != joint.name) {  // several, of any kind
    if (choose.chance(0.5)) all.emplace_back("friction", "{ coulomb = 0.1, speed = 0.2 }");
  } else if (joint.kind->nv == 1 && !joint.coupled && choose.chance(joint.moves ? 0.5 : 0.1)) {
    all.emplace_back("drive", "{ motion = { rate = " + choose.number(-1, 1) + " } }");
  } else if (joint.moves) {
    all.emplace_back("drive", choose.word({"{ effort = 0 }", "{ pd = { kp = 5, kd = 0.5 } }"}));
  } else {
    for (auto& entry : random_parameters(draft, *joint.kind, false)) all.push_back(std::move(entry));
  }
  if (all.size() == 1) all.emplace_back("damping", choose.magnitude(-2, 0));
  return braces(all);
}

// A body of a floating mechanism and one of another mechanism, as at the start; sometimes any two.
std::pair<std::string, std::string> two_bodies(Draft& draft) {
  Choices& choose = draft.choose;
  const auto in = [](const std::string& body, const std::string& mechanism) { return body.starts_with(mechanism + "/"); };
  const auto of = [&](std::size_t mechanism, bool inside) {
    std::vector<std::string> found{"ground"};
    for (const std::string& body : draft.bodies)
      if (in(body, draft.mechanisms[mechanism]) == inside) found.push_back(body);
    if (inside) found.erase(found.begin());
    return found;
  };
  std::vector<std::size_t> floating;
  for (std::size_t m = 0; m < draft.floats.size(); ++m)
    if (draft.floats[m]) floating.push_back(m);
  if (floating.empty() || (!draft.certain && choose.chance(0.3)))
    return {choose.pick(draft.bodies), choose.chance(0.25) ? "ground" : choose.pick(draft.bodies)};
  const std::size_t mechanism = choose.pick(floating);
  if (choose.chance(0.8)) draft.floats[mechanism] = false;
  const std::string body = choose.pick(of(mechanism, true));
  return {body, choose.pick(of(mechanism, false))};
}

std::string joining(Draft& draft, bool weld, bool named, int number) {
  Choices& choose = draft.choose;
  const auto [body, other] = two_bodies(draft);
  Entries all{{"body", quoted(body)}};
  if (other != "ground" || !weld || choose.chance(0.3)) all.emplace_back("to", quoted(other));
  const KindInfo& kind = weld ? info(Kind::weld) : choose.pick(all_kinds());
  if (!weld) {
    for (auto& entry : new_joint(draft, kind, true)) all.push_back(std::move(entry));
    if (choose.chance(0.3)) all.emplace_back("at", in_braces("xyz", choose.vector(0.5)));
  }
  Joint made{named ? "e" + std::to_string(number) : other + "+" + body, body, &kind};
  made.made = true;
  draft.joints.push_back(made);
  return braces(all);
}

std::string impulse(Draft& draft, const std::string& body) {
  Choices& choose = draft.choose;
  Entries all{{"body", quoted(body)}};
  if (choose.chance(0.8)) all.emplace_back("force", choose.vector(0.5));
  if (all.size() == 1 || choose.chance(0.4)) all.emplace_back("torque", choose.vector(0.1));
  if (choose.chance(0.4)) all.emplace_back("point", choose.vector(0.3));
  return braces(all);
}

// An action with its key, which may be replaced by another key. `late`: its instant is not known, so that joints which other
// events make may exist.
std::string action(Draft& draft, std::string& key, bool named, bool late, int number) {
  if (key == "weld" || key == "attach") return joining(draft, key == "weld", named, number);
  if (key == "unlock") {
    std::vector<std::string> locked;
    for (Joint& joint : draft.joints)
      if (joint.locked && !joint.decided) locked.push_back(joint.name);
    if (!locked.empty()) return quoted(draft.choose.pick(locked));
    key = "lock";
  }
  const bool decides = key == "break" || key == "free" || key == "change";
  const bool frees = key == "break" || key == "free";
  Joint& joint = some_joint(
      draft, late,
      key == "lock" || key == "set" ? has_dofs
      : frees                       ? [](const Joint& j) { return j.kind->kind != Kind::free; }
      : key == "change"             ? [](const Joint& j) { return !j.coupled; }
                                    : [](const Joint&) { return true; });
  const Named wild = names(draft, joint);
  joint.decided = joint.decided || decides;
  if (key == "impulse") return impulse(draft, wild.body);
  if (key == "set") return set(draft, joint, wild.joint);
  if (key == "change") return change(draft, joint, joint.name);
  if (key == "lock") return joint.locked = true, dofs(draft, joint, wild.joint);
  return quoted(wild.joint);
}

std::string time_text(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", time);
  return text;
}

std::string point(Draft& draft) {
  const std::string body = quoted(draft.choose.pick(draft.bodies));
  return draft.choose.chance(0.6) ? body : braces({{"body", body}, {"point", draft.choose.vector(0.3)}});
}

std::string condition(Draft& draft) {
  Choices& choose = draft.choose;
  const Joint& joint = some_joint(draft, true, has_dofs);
  const std::string wild = choose.chance(0.15) ? choose.pick(draft.mechanisms) + "/*" : joint.name;
  Entries all;
  std::string threshold;
  int what = choose.integer(0, draft.solids.empty() ? 8 : 10);
  if (what < 2 && joint.kind->nv != 1) what = 2 + choose.integer(0, 6);
  switch (what) {
    case 0: all = {{"position", quoted(joint.name)}}, threshold = choose.number(-1, 1); break;
    case 1: all = {{"speed", quoted(joint.name)}}, threshold = choose.number(-3, 3); break;
    case 2: all = {{"reaction_force", quoted(wild)}}, threshold = choose.magnitude(-1, 1); break;
    case 3: all = {{"reaction_torque", quoted(wild)}}, threshold = choose.magnitude(-2, 0); break;
    case 4:
      all = {
          {"reaction", braces({{"joint", quoted(wild)}, {"component", choose.word({"\"fx\"", "\"fz\"", "\"my\"", "\"mz\""})}})}};
      threshold = choose.number(-10, 10);
      break;
    case 5: all = {{"reaction_impulse", quoted(wild)}}, threshold = choose.magnitude(-3, 0); break;
    case 6: {
      const std::string one = point(draft), other = choose.chance(0.3) ? "\"ground\"" : point(draft);
      all = {{"distance", "[" + one + ", " + other + "]"}}, threshold = choose.number(0.1, 2);
      break;
    }
    case 7: all = {{"height", point(draft)}}, threshold = choose.number(-1, 1); break;
    case 9: all = {{choose.word({"gap", "slip"}), touching_pair(draft)}}, threshold = choose.number(0, 0.3); break;
    case 10:
      all = {{choose.word({"contact_force", "contact_impulse"}), touching_pair(draft)}}, threshold = choose.magnitude(-1, 1);
      break;
    default: all = {{"kinetic_energy", quoted(choose.pick(draft.mechanisms))}}, threshold = choose.magnitude(-2, 1);
  }
  all.emplace_back(choose.word({"exceeds", "below"}), threshold);
  return braces(all);
}

// The keys of the trigger; returns whether it depends on a condition.
bool trigger(Draft& draft, Entries& all) {
  Choices& choose = draft.choose;
  const int what = choose.integer(0, draft.certain ? 6 : 9);
  const double grid = draft.until / 20;
  if (what < 4 || (what < 6 && draft.events.empty())) {
    all.emplace_back("at", time_text(choose.integer(0, 20) * grid));
  } else if (what < 6) {
    const Draft::DraftEvent before = choose.pick(draft.events);
    const Joint& joint = some_joint(draft, false, [](const Joint& j) { return j.strong; });
    const bool strength = joint.strong && choose.chance(0.5);
    const std::string name = quoted(strength ? "strength of " + joint.name : before.name);
    all.emplace_back("after",
                     choose.chance(0.3) ? name : braces({{"event", name}, {"delay", time_text(choose.integer(0, 8) * grid)}}));
    return before.waits || strength;
  } else if (what == 6 && (draft.certain || choose.chance(0.6))) {
    all.emplace_back("every", time_text(choose.integer(3, 10) * grid));
    if (choose.chance(0.5)) all.emplace_back("from", time_text(choose.integer(0, 10) * grid));
  } else {
    all.emplace_back("when", condition(draft));
    if (choose.chance(0.3)) all.emplace_back("repeat", "true");
    if (all.back().first == "repeat" && choose.chance(0.5)) all.emplace_back("hysteresis", choose.magnitude(-3, -1));
    if (choose.chance(0.2)) all.emplace_back("for", time_text(choose.integer(1, 4) * grid / 2));
    if (choose.chance(0.15)) all.emplace_back("locate", "\"per step\"");
    return true;
  }
  return false;
}

}  // namespace

void add_event(Draft& draft) {
  const int number = static_cast<int>(draft.events.size()) + 1;
  const bool named = draft.choose.chance(0.6);
  const std::string name = named ? "e" + std::to_string(number) : "#" + std::to_string(number);
  Entries all;
  if (named) all.emplace_back("name", quoted(name));
  const bool waits = trigger(draft, all);
  static const std::vector<std::string> keys{"break",  "break", "free",   "change",  "lock", "lock", "unlock",
                                             "unlock", "weld",  "attach", "impulse", "set",  "set",  "set"};
  Entries actions;
  for (int left = draft.choose.chance(0.7) ? 1 : draft.choose.integer(2, 3); left > 0; --left) {
    std::string key = draft.choose.pick(keys);
    const bool joins = key == "weld" || key == "attach";
    if (joins && (has(actions, "weld") || has(actions, "attach"))) key = "impulse";  // it makes one joint, with its own name
    const std::string value = action(draft, key, named, waits, number);
    bool joined = false;
    for (auto& [known, list] : actions)
      if (known == key)
        list = "[" + (list.front() == '[' ? list.substr(1, list.size() - 2) : list) + ", " + value + "]", joined = true;
    if (!joined) actions.emplace_back(key, value);
  }
  draft.events.push_back({name, waits});
  draft.text += "\n[[event]]\n" + lines(all) + lines(actions);
}

}  // namespace momentree::fuzz
