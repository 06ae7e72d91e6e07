#pragma once
// Common base of the quantities that are loads on a joint or, where that makes sense, on a spring.
#include <cmath>

#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::quantities {

struct Load : Quantity {
  std::string joint;

  void arguments(const ArgumentVisitor& visit) override { visit({"joint", argument::Joint{joint}}); }
  std::vector<std::string> joints() const override { return {joint}; }
  bool is_load() const override { return true; }
  bool never_negative() const override { return true; }
  virtual std::optional<double> of(const Wrench& wrench) const = 0;
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const int number = world.find_joint(joint, number_);
    if (number >= 0 && is_broken(world, joint, {number})) return std::nullopt;
    if (number >= 0) return of(world.reaction({number}));
    const int spring = takes_springs() ? world.find_spring(joint, spring_) : -1;
    if (spring < 0 || !spring_acts(world.tree(), spring)) return std::nullopt;
    return std::fabs(world.spring({spring}).tension);
  }

 private:
  mutable std::atomic<int> number_ = -1, spring_ = -1;  // a condition may be shared by worlds in several threads
};

}  // namespace momentree::quantities
