#pragma once
// Speed with which two bodies slip on each other (m/s).
#include <momentree/simulate/of_contact.hpp>

namespace momentree::quantities {

struct Slip : OfContact {
  std::string_view key() const override { return "slip"; }
  const char* summary() const override {
    return "Largest speed with which two bodies slip on each other; 0 if they do not touch (m/s)";
  }
  Dimension dimension() const override { return dimension::speed; }
  bool never_negative() const override { return true; }
  std::optional<double> value(const World& world, std::span<const Event>) const override {
    if (!exist(world)) return std::nullopt;
    double most = 0;
    each_point(world, [&](const ContactPoint& point, double) { most = std::max(most, norm(point.slip)); });
    return most;
  }
};

}  // namespace momentree::quantities
