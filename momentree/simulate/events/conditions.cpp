#include <momentree/simulate/all_quantities.hpp>  // generated: includes the files in quantities/
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/quantity_list.hpp>  // generated from these files
#include <momentree/simulate/world/world.hpp>

namespace momentree {

std::optional<double> Condition::value(const World& world, std::span<const Event> now) const {
  const Stamp stamp = world.stamp();
  if (seen_ == stamp) return last_;
  if (what->is_impulsive()) return what->value(world, now);
  last_ = what->value(world, now);  // may throw: then nothing is cached
  seen_ = stamp;
  return last_;
}

std::optional<double> Condition::excess(const World& world, std::span<const Event> now) const {
  const std::optional<double> found = value(world, now);
  if (!found) return std::nullopt;
  return above ? *found - threshold : threshold - *found;
}

std::shared_ptr<Quantity> make_quantity(std::string_view key) {
#define MOMENTREE_QUANTITY(name, Type) \
  if (key == #name) return std::make_shared<quantities::Type>();
  MOMENTREE_QUANTITIES(MOMENTREE_QUANTITY)
#undef MOMENTREE_QUANTITY
  return nullptr;
}

std::vector<std::string> quantity_keys() {
  return {
#define MOMENTREE_QUANTITY(name, Type) #name,
      MOMENTREE_QUANTITIES(MOMENTREE_QUANTITY)
#undef MOMENTREE_QUANTITY
  };
}

namespace {

template <class Q>
Measure of_joint(std::string joint) {
  auto quantity = std::make_shared<Q>();
  quantity->joint = std::move(joint);
  return Measure(std::move(quantity));
}

template <class Q>
std::shared_ptr<Q> of_bodies(std::string one, std::string other) {
  auto quantity = std::make_shared<Q>();
  quantity->one = std::move(one), quantity->other = std::move(other);
  return quantity;
}

// A user-defined function; it cannot be written to files.
struct Function : Quantity {
  std::function<double(const World&)> function;
  std::string_view key() const override { return "function"; }
  const char* summary() const override { return "A function of the world's state"; }
  void arguments(const ArgumentVisitor&) override {}
  Dimension dimension() const override { return {}; }
  std::optional<double> value(const World& world, std::span<const Event>) const override { return function(world); }
};

}  // namespace

Measure reaction_force(std::string joint) { return of_joint<quantities::ReactionForce>(std::move(joint)); }
Measure reaction_torque(std::string joint) { return of_joint<quantities::ReactionTorque>(std::move(joint)); }
Measure reaction_impulse(std::string joint) { return of_joint<quantities::ReactionImpulse>(std::move(joint)); }
Measure position_of(std::string joint) { return of_joint<quantities::Position>(std::move(joint)); }
Measure speed_of(std::string joint) { return of_joint<quantities::Speed>(std::move(joint)); }

Measure reaction(std::string joint, std::string component) {
  if (component.size() != 2 || (component[0] != 'f' && component[0] != 'm') || component[1] < 'x' || component[1] > 'z')
    throw_error({"a reaction has no component '" + component + "'", "", "one of fx fy fz mx my mz"});
  auto quantity = std::make_shared<quantities::Reaction>();
  quantity->joint = std::move(joint), quantity->component = std::move(component);
  return Measure(std::move(quantity));
}

Measure distance_between(std::string one, std::string other, Vec3 point_of_one, Vec3 point_of_other) {
  auto quantity = std::make_shared<quantities::Distance>();
  quantity->one = std::move(one), quantity->other = std::move(other);
  quantity->point_of_one = point_of_one, quantity->point_of_other = point_of_other;
  return Measure(std::move(quantity));
}

Measure height_of(std::string body, Vec3 point) {
  auto quantity = std::make_shared<quantities::Height>();
  quantity->name = std::move(body), quantity->point = point;
  return Measure(std::move(quantity));
}

Measure kinetic_energy_of(std::string mechanism) {
  auto quantity = std::make_shared<quantities::KineticEnergy>();
  quantity->name = std::move(mechanism);
  return Measure(std::move(quantity));
}

Measure gap_between(std::string one, std::string other) {
  return Measure(of_bodies<quantities::Gap>(std::move(one), std::move(other)));
}
Measure contact_force_between(std::string one, std::string other) {
  return Measure(of_bodies<quantities::ContactForce>(std::move(one), std::move(other)));
}
Measure contact_impulse_between(std::string one, std::string other) {
  return Measure(of_bodies<quantities::ContactImpulse>(std::move(one), std::move(other)));
}
Measure slip_between(std::string one, std::string other) {
  return Measure(of_bodies<quantities::Slip>(std::move(one), std::move(other)));
}
Condition touching(std::string one, std::string other) {
  return {of_bodies<quantities::Touch>(std::move(one), std::move(other)), 0.5, true};
}
Condition beginning_to_slip(std::string one, std::string other) {
  const auto slip = of_bodies<quantities::Slip>(std::move(one), std::move(other));
  slip->drop_threshold();
  return {slip, 0.5, true};
}

Measure measured(std::function<double(const World&)> function) {
  if (!function) throw_error({"measured() needs a function", "", ""});
  auto quantity = std::make_shared<Function>();
  quantity->function = std::move(function);
  return Measure(std::move(quantity));
}

}  // namespace momentree
