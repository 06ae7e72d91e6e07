#pragma once
// What the quantities of contacts have in common.
#include <algorithm>

#include <momentree/simulate/contact/contact_bodies.hpp>
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

struct OfContact : Quantity {
  std::string one, other;  ///< bodies or mechanisms; "ground" is the floor, too

  void arguments(const ArgumentVisitor& visit) override { visit({"solids", argument::TwoSolids{one, other}}); }
  std::vector<std::string> solids() const override { return {one, other}; }

  /// False if it also makes sense for bodies that pass through each other.
  virtual bool needs_contact() const { return true; }
  /// True if it only makes sense for bodies with friction.
  virtual bool needs_friction() const { return false; }
  /// True for sums of vectors, which the order of the two names determines: no body may belong to both.
  virtual bool is_sum() const { return false; }

 protected:
  /// Calls f with each point at which they touch, and with the sign of its force on `one`.
  template <class F>
  void each_point(const World& world, const F& f) const {
    const ContactBodies a(world.model(), one), b(world.model(), other);
    for (const ContactPoint& point : world.contacts()) {
      if (a.holds(point.one) && b.holds(point.other))
        f(point, 1.0);
      else if (a.holds(point.other) && b.holds(point.one))
        f(point, -1.0);
    }
  }
  /// The sign of the event's impulse on `one`; 0 for an event of other bodies.
  double sign_of(const World& world, const Event& event) const {
    if (event.contact.one.empty() || !event.contact.cable.empty()) return 0;
    const ContactBodies a(world.model(), one), b(world.model(), other);
    if (a.holds(event.contact.one) && b.holds(event.contact.other)) return 1;
    return a.holds(event.contact.other) && b.holds(event.contact.one) ? -1 : 0;
  }
  bool is_of(const World& world, const Event& event) const { return sign_of(world, event) != 0; }
  std::optional<BodyGap> gap(const World& world) const {
    return world.gap(ContactBodies(world.model(), one), ContactBodies(world.model(), other));
  }
  bool exist(const World& world) const {
    return ContactBodies(world.model(), one).exist(world) && ContactBodies(world.model(), other).exist(world);
  }
};

}  // namespace momentree
