#include <momentree/simulate/events/strengths.hpp>

#include <cmath>

#include <momentree/simulate/world/world.hpp>

namespace momentree {

namespace {

// Like the quantities reaction_force and reaction_torque, but by joint number: evaluated after every step.
struct Load : Quantity {
  Strength strength;
  explicit Load(const Strength& s) : strength(s) {}
  std::string_view key() const override { return strength.torque ? "reaction_torque" : "reaction_force"; }
  const char* summary() const override { return "Load on a joint, relative to its strength"; }
  void arguments(const ArgumentVisitor&) override {}
  Dimension dimension() const override { return strength.torque ? dimension::torque : dimension::force; }
  bool is_load() const override { return true; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    if (strength.spring >= 0) {
      if (!spring_acts(world.tree(), strength.spring)) return std::nullopt;
      return std::fabs(world.spring({strength.spring}).tension);
    }
    const bool exists = is_loop({strength.joint}) ? world.tree().loops().find({strength.joint}) != nullptr
                                                  : world.tree().carrier(strength.joint) >= 0;
    if (!exists) return std::nullopt;
    const Wrench wrench = world.reaction({strength.joint});
    return norm(strength.torque ? wrench.torque : wrench.force);
  }
};

}  // namespace

bool has_strengths(const World& world) {
  const Tree& tree = world.tree();
  if (!tree.joints_with().strengths.empty() || has_spring_strengths(tree)) return true;
  for (const Loop& loop : tree.loops())
    if (loop.parameters.strength.any()) return true;
  return false;
}

std::vector<Strength> strengths(const World& world) {
  std::vector<Strength> all;
  const Tree& tree = world.tree();
  for (const int b : tree.joints_with().strengths) {
    const JointStrength& s = tree.parameters(b)->strength;
    if (std::isfinite(s.force)) all.push_back({tree.joint_of(b), false, s.force});
    if (std::isfinite(s.torque)) all.push_back({tree.joint_of(b), true, s.torque});
  }
  for (const Loop& loop : tree.loops()) {
    const JointStrength& s = loop.parameters.strength;
    if (std::isfinite(s.force)) all.push_back({loop.id().index, false, s.force});
    if (std::isfinite(s.torque)) all.push_back({loop.id().index, true, s.torque});
  }
  for (int s = 0; s < tree.springs().count(); ++s)
    if (std::isfinite(tree.springs().law(s).strength) && spring_acts(tree, s))
      all.push_back({-1, false, tree.springs().law(s).strength, s});
  return all;
}

std::string name_of(const World& world, const Strength& strength) {
  if (strength.spring >= 0) return world.model().springs()[static_cast<std::size_t>(strength.spring)].name;
  return std::string(world.joint_name({strength.joint}));
}

std::optional<Error> undetermined_strength(const World& world) {
  if (!world.tree().has_loops()) return std::nullopt;
  for (const Strength& strength : strengths(world))
    if (strength.spring < 0 && !world.loops_determine({strength.joint}, strength.torque ? torque_parts : force_parts))
      return Error("strength: the closed loops do not determine its reaction",
                   "joint '" + std::string(world.joint_name({strength.joint})) + "'",
                   "let loops block fewer directions, for example by a ball and a universal joint instead of revolute ones "
                   "(explain counts "
                   "the equations), or use an event whose condition says undetermined = \"least_norm\"");
  return std::nullopt;
}

Condition condition_of(const Strength& strength) { return {std::make_shared<Load>(strength), strength.most, true}; }

std::string event_name(const World& world, const Strength& strength) { return "strength of " + name_of(world, strength); }

}  // namespace momentree
