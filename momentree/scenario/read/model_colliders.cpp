// Collision elements of model files as colliders: which of them count, their friction, and pairs that touch or do not.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

using Set = Reading::ModelColliders;
using Masks = std::vector<CollisionMask>;  // of the solids of a body, each once and in order; empty: it has none
using Warn = std::function<void(const std::string& what, const std::string& hint)>;

// By body of the model: the first one of those that are welded together; −1: they are part of the ground.
std::vector<int> rigid_groups(const Model& model, int first, int count) {
  std::vector<int> group(static_cast<std::size_t>(count));
  for (int b = 0; b < count; ++b) {
    const BodySpec& spec = model[BodyId{first + b}];
    int own = b;
    if (spec.joint.kind == Kind::weld)
      own = spec.parent == ground ? -1 : group[static_cast<std::size_t>(spec.parent.index - first)];
    group[static_cast<std::size_t>(b)] = own;
  }
  return group;
}

void pass_through(Model& model, std::vector<BodyId> one, std::vector<BodyId> other) {
  ContactRule rule;
  rule.one = std::move(one), rule.other = std::move(other), rule.law.off = true;
  model.add_contact_rule(std::move(rule));
}
void exclude_pair(Model& model, BodyId one, BodyId other) { pass_through(model, {one}, {other}); }

// Friction of single bodies and of the ground. Where two of them have coefficients, the last rule counts.
void add_friction(const ImportedModel& imported, int first, double of_ground, Model& model) {
  std::map<double, std::vector<BodyId>> by_friction;
  for (std::size_t b = 0; b < imported.bodies.size(); ++b)
    if (imported.bodies[b].friction >= 0) by_friction[imported.bodies[b].friction].push_back({first + static_cast<int>(b)});
  if (of_ground >= 0) by_friction[of_ground].push_back(ground);
  const auto add = [&](const auto& entry) {
    ContactRule rule;
    rule.one = entry.second;
    rule.law.friction = rule.law.static_friction = entry.first;
    model.add_contact_rule(std::move(rule));
  };
  if (imported.friction_of_two == FrictionOfTwo::larger)
    std::for_each(by_friction.begin(), by_friction.end(), add);
  else
    std::for_each(by_friction.rbegin(), by_friction.rend(), add);
}

// Bodies that are welded together and neighbours across joints of such groups, unless a joint connects the two, which are apart
// for as long as it does; and pairs that the file excludes.
void add_exclusions(const ImportedModel& imported, int first, const std::vector<Masks>& masks, Model& model,
                    const std::function<void(const std::string&)>& unknown) {
  const int count = static_cast<int>(imported.bodies.size());
  const std::vector<int> group = rigid_groups(model, first, count);
  const auto group_of = [&](int b) { return b < 0 ? -1 : group[static_cast<std::size_t>(b)]; };
  const auto parent_of = [&](int g) {
    if (g < 0) return -2;
    const BodyId parent = model[BodyId{first + g}].parent;
    return parent == ground ? -1 : group_of(parent.index - first);
  };
  for (int b = 0; b < count; ++b) {
    if (masks[static_cast<std::size_t>(b)].empty()) continue;
    for (int other = 0; other < b; ++other) {
      if (masks[static_cast<std::size_t>(other)].empty()) continue;
      const int g = group_of(b), h = group_of(other);
      if (model[BodyId{first + b}].parent.index == first + other || model[BodyId{first + other}].parent.index == first + b)
        continue;
      if (g == h || parent_of(g) == h || parent_of(h) == g) exclude_pair(model, {first + b}, {first + other});
    }
  }
  const auto body_of = [&](const std::string& name) -> std::optional<BodyId> {
    if (name == "world") return ground;
    for (int b = 0; b < count; ++b)
      if (imported.bodies[static_cast<std::size_t>(b)].spec.name == name) return BodyId{first + b};
    unknown(name);
    return std::nullopt;
  };
  for (const auto& [one, other] : imported.excluded)
    if (const auto a = body_of(one), b = body_of(other); a && b) exclude_pair(model, *a, *b);
}

// By body, its pose in the world if it is part of the ground.
std::vector<std::optional<Pose>> fixed_poses(const Model& model, int first, int count) {
  std::vector<std::optional<Pose>> poses;
  for (int b = 0; b < count; ++b) {
    const BodySpec& spec = model[BodyId{first + b}];
    std::optional<Pose> pose;
    if (spec.joint.kind == Kind::weld)
      pose = spec.parent == ground ? Pose{} : poses[static_cast<std::size_t>(spec.parent.index - first)];
    if (pose) pose = *pose * spec.at * inverse(spec.child_at);
    poses.push_back(pose);
  }
  return poses;
}

// A plane that is where another one is, such as the floor, and a solid that is there already, are not added.
void add_to_ground(Collider collider, Model& model) {
  constexpr double near = 1e-9;
  const auto same = [&](const Collider& other) {
    if (other.body != ground || other.plane != collider.plane) return false;
    if (collider.field || other.field) return collider.field && other.field && *collider.field == *other.field;
    if (!collider.plane) return other.solid == collider.solid;
    const double apart = dot(collider.normal, collider.point - other.point);
    return norm(other.normal - collider.normal) < near && std::fabs(apart) < near * std::max(1.0, norm(other.point));
  };
  const std::vector<Collider>& all = model.colliders();
  if (std::none_of(all.begin(), all.end(), same)) model.add_collider(std::move(collider));
}

void sort(Masks& masks) {
  std::sort(masks.begin(), masks.end());
  masks.erase(std::unique(masks.begin(), masks.end()), masks.end());
}

// What was added for a model: masks by body, and those of the ground with its friction.
struct Added {
  std::vector<Masks> masks{};
  Masks of_ground{};
  double friction_of_ground = -1;
};

Added add_solids(const Set& set, Reading& reading) {
  const ImportedModel& imported = set.import->model;
  Model& model = reading.scenario.model;
  Added added;
  int left_out = 0;
  std::string first_left_out;
  const auto add = [&](const ImportedSolids& part, const std::string& name, BodyId body, const std::optional<Pose>& fixed) {
    const auto tell = [&](const std::string& what, const std::string& hint) {
      reading.out.warning(set.place, "collision of " + in_quotes(name) + ": " + what, hint);
    };
    const auto leave_out = [&](const std::string& what, const std::string&) {
      if (++left_out == 1) first_left_out = in_quotes(name) + ": " + what;
    };
    const auto fail = [&](const std::string& what, const std::string& hint) {
      reading.out.error(set.place, "collision of " + in_quotes(name) + ": " + what,
                        hint + "; split = false in the mechanism lets hulls touch");
    };
    const ShapeReports reports{leave_out, tell, tell, fail};
    Masks own;
    for (std::size_t s = 0; s < part.collision.size(); ++s) {
      Shape shape = part.collision[s];
      shape.split = set.split.value_or(shape.split);
      const CollisionMask mask = s < part.masks.size() ? part.masks[s] : CollisionMask{};
      if (body == ground || (fixed && is_of_ground(shape.kind))) {
        for (Collider& collider : ground_colliders(shape, *fixed, reports)) {
          add_to_ground(std::move(collider), model);
          added.of_ground.push_back(mask);
          added.friction_of_ground = std::max(added.friction_of_ground, part.friction);
        }
      } else if (std::vector<contact::Solid> solids = solids_of(shape, reports); !solids.empty()) {
        add_colliders(body, solids, model);
        own.push_back(mask);
      }
    }
    sort(own);
    return own;
  };
  add(imported.ground, "ground", ground, set.pose);
  const int count = static_cast<int>(imported.bodies.size());
  const std::vector<std::optional<Pose>> fixed = fixed_poses(model, set.first, count);
  for (int b = 0; b < count; ++b) {
    const auto n = static_cast<std::size_t>(b);
    const BodyId body{set.first + b};
    added.masks.push_back(add(imported.bodies[n], model[body].name, body, fixed[n]));
  }
  if (added.of_ground.empty()) added.of_ground = imported.ground.masks;
  if (added.of_ground.empty()) added.of_ground = {{}};
  sort(added.of_ground);
  if (left_out > 0)
    reading.out.warning(set.place,
                        std::to_string(left_out) + (left_out == 1 ? " collision element touches" : " collision elements touch") +
                            " nothing, such as that of " + first_left_out,
                        "collision = \"none\" in the mechanism leaves all of them out");
  return added;
}

// Bodies of which no solids touch by their masks pass through each other. Where only some do, whole bodies touch.
void add_masks(const Set& set, const Added& added, Model& model, const Warn& warn) {
  const std::vector<Masks>& masks = added.masks;
  std::map<Masks, std::vector<BodyId>> alike;
  for (std::size_t b = 0; b < masks.size(); ++b)
    if (!masks[b].empty()) alike[masks[b]].push_back({set.first + static_cast<int>(b)});
  std::string mixed;
  const auto add = [&](const auto& one, const Masks& other, const std::vector<BodyId>& bodies) {
    std::size_t touching = 0;
    for (const CollisionMask& a : one.first)
      for (const CollisionMask& b : other) touching += touch_by_masks(a, b) ? 1 : 0;
    if (touching == 0)
      pass_through(model, one.second, bodies);
    else if (touching < one.first.size() * other.size() && mixed.empty() && (one.second != bodies || bodies.size() > 1))
      mixed = in_quotes(model[one.second.front()].name) + " and " +
              (bodies.back() == ground ? std::string("the ground") : in_quotes(model[bodies.back()].name));
  };
  for (auto one = alike.begin(); one != alike.end(); ++one) {
    add(*one, added.of_ground, {ground});
    for (auto other = alike.begin(); other != std::next(one); ++other) add(*one, other->first, other->second);
  }
  if (!mixed.empty())
    warn("contype and conaffinity let only some geoms of two bodies touch, such as those of " + mixed + ": all of them do here",
         "[[contact]] with off = true lets two bodies pass through each other");
}

// <pair>s take precedence over masks and exclusions.
void add_pairs(const ImportedModel& imported, int first, Model& model) {
  const auto number = [first](int body) { return body < 0 ? ground : BodyId{first + body}; };
  for (const ImportedPair& pair : imported.pairs) {
    ContactRule rule;
    rule.one = {number(pair.one)}, rule.other = {number(pair.other)};
    rule.law.friction = rule.law.static_friction = pair.friction;
    model.add_contact_rule(std::move(rule));
  }
}

}  // namespace

void add_model_colliders(bool rules, Reading& reading) {
  Model& model = reading.scenario.model;
  const bool something =
      rules || !model.colliders().empty() ||
      std::any_of(reading.model_colliders.begin(), reading.model_colliders.end(), [](const Set& set) { return set.always; });
  if (!something) reading.model_colliders.clear();
  std::vector<Added> added;
  for (const Set& set : reading.model_colliders) {
    added.push_back(add_solids(set, reading));
    add_friction(set.import->model, set.first, added.back().friction_of_ground, model);
  }
  if (reading.floor_rule) model.add_contact_rule(std::move(*reading.floor_rule));
  for (std::size_t i = 0; i < added.size(); ++i) {
    const Set& set = reading.model_colliders[i];
    const auto warn = [&](const std::string& what, const std::string& hint) { reading.out.warning(set.place, what, hint); };
    add_masks(set, added[i], model, warn);
    add_exclusions(set.import->model, set.first, added[i].masks, model, [&](const std::string& name) {
      warn("<exclude> names " + in_quotes(name) + ", which is not a body of the model", "");
    });
    add_pairs(set.import->model, set.first, model);
  }
}

std::optional<Overlap> overlap_between_models(Reading& reading) {
  Model& model = reading.scenario.model;
  constexpr int most_pairs = 300;
  constexpr int shown = 3;
  std::map<const Set*, std::pair<int, std::string>> left_out;
  const auto set_of = [&](const std::string& name) -> const Set* {
    for (const Set& set : reading.model_colliders)
      if (mechanism_of(name) == set.mechanism) return &set;
    return nullptr;
  };
  const auto number = [&model](const std::string& name) { return name == "ground" ? ground : model.body(name); };
  // Collision elements of what a joint holds at the ground often reach into the ground of the file.
  const auto held_in_own_ground = [&](const Set* set, const Overlap& overlap) {
    if (set == nullptr || overlap.other != "ground" || set->import->model.ground.collision.empty()) return false;
    const BodySpec& body = model[model.body(overlap.one)];
    return body.parent == ground && body.joint.kind != Kind::free;
  };
  std::optional<Overlap> worst;
  Model rest = model;  // without the pairs that were looked at
  for (int k = 0; k < most_pairs; ++k) {
    const std::optional<Overlap> next = deepest_overlap(rest);
    if (!next) break;
    const Set* const set = next->cable.empty() ? set_of(next->one) : nullptr;
    const bool within = set != nullptr && (set_of(next->other) == set || held_in_own_ground(set, *next));
    if (!worst && !within) worst = next;
    if (!next->cable.empty()) break;
    if (!within && (!reading.scenario.integration.resolve || reading.model_colliders.empty())) break;
    exclude_pair(rest, number(next->one), number(next->other));
    if (!within) continue;  // is pushed apart
    exclude_pair(model, number(next->one), number(next->other));
    auto& [count, names] = left_out[set];
    if (++count <= shown) names += (names.empty() ? "" : ", ") + in_quotes(next->one) + " and " + in_quotes(next->other);
  }
  for (const Set& set : reading.model_colliders) {
    const auto found = left_out.find(&set);
    if (found == left_out.end()) continue;
    const auto& [count, names] = found->second;
    reading.out.warning(set.place,
                        "bodies of the model overlap at the start and pass through each other: " + names +
                            (count > shown ? " and " + std::to_string(count - shown) + " more pairs" : ""),
                        "[[contact]] with off = true says so");
  }
  return worst;
}

}  // namespace momentree::io
