#pragma once
// Common base of the quantities of a joint with one DoF.
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::quantities {

struct SingleDof : Quantity {
  std::string joint;
  bool turns = true;  ///< for its unit, set by file readers

  void arguments(const ArgumentVisitor& visit) override { visit({"joint", argument::Joint{joint}}); }
  std::vector<std::string> joints() const override { return {joint}; }
  bool of_single_dof() const override { return true; }
  virtual double of(double position, double speed) const = 0;
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const auto state = present(world);
    return state ? std::optional(of(state->first, state->second)) : std::nullopt;
  }

 protected:
  /// Coordinate and velocity; empty if the joint no longer exists or is of another kind.
  std::optional<std::pair<double, double>> present(const World& world) const {
    const int number = world.find_joint(joint, number_);
    if (number < 0) return std::nullopt;
    return world.single_dof({number});
  }

 private:
  mutable std::atomic<int> number_ = -1;  // a condition may be shared by worlds in several threads
};

}  // namespace momentree::quantities
