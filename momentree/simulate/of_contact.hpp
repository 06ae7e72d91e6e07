#pragma once
// What the quantities of contacts between two bodies have in common.
#include <algorithm>

#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

struct OfContact : Quantity {
  std::string one, other;  ///< bodies; "ground" is the floor, too

  void fields(QuantityFields& fields) override { fields.solid(0, one), fields.solid(1, other); }
  std::vector<std::string> bodies() const override { return {one, other}; }

 protected:
  /// Calls f with each point at which they touch, and with the sign of its force on `one`.
  template <class F>
  void each_point(const World& world, const F& f) const {
    const BodyId a = number(world, one), b = number(world, other);
    for (const ContactPoint& point : world.contacts()) {
      if (point.one == a && point.other == b) f(point, 1.0);
      if (point.one == b && point.other == a) f(point, -1.0);
    }
  }
  bool is_of(const Event& event) const {
    if (!event.contact.cable.empty()) return false;
    return (event.contact.one == one && event.contact.other == other) ||
           (event.contact.one == other && event.contact.other == one);
  }
  static BodyId number(const World& world, const std::string& name) {
    return name == "ground" ? ground : world.model().body(name);
  }
  bool exist(const World& world) const {
    for (const std::string& name : {one, other})
      if (const BodyId body = number(world, name); body != ground && !world.alive(body)) return false;
    return true;
  }
};

}  // namespace momentree
