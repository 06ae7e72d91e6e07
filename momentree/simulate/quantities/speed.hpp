#pragma once
// Speed of a joint with one freedom.
#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::quantities {

struct Speed : Quantity {
  std::string joint;
  bool turns = true;  ///< for its unit; readers of files know

  std::string_view key() const override { return "speed"; }
  Dimension dimension() const override { return turns ? dimension::angular_speed : dimension::speed; }
  void fields(QuantityFields& fields) override { fields.joint(joint); }
  std::vector<std::string> joints() const override { return {joint}; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    const int number = world.find_joint(joint);
    if (number < 0) return std::nullopt;
    const JointView view = world.joint({number});
    if (view.q.size() != 1 || view.v.size() != 1) return std::nullopt;
    return view.v[0];
  }
};

}  // namespace momentree::quantities
