#pragma once
// What the quantities of a joint with one freedom share.
#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::quantities {

struct OneFreedom : Quantity {
  std::string joint;
  bool turns = true;  ///< for its unit; readers of files know

  void fields(QuantityFields& fields) override { fields.joint(joint); }
  std::vector<std::string> joints() const override { return {joint}; }
  virtual double of(const JointView& view) const = 0;
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const int number = world.find_joint(joint);
    if (number < 0) return std::nullopt;
    const JointView view = world.joint({number});
    return view.q.size() == 1 && view.v.size() == 1 ? std::optional(of(view)) : std::nullopt;
  }
};

}  // namespace momentree::quantities
