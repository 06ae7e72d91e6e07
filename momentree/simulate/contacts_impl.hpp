#pragma once
// What the files that implement Contacts share: quantities of contacts that are located within steps, and tolerances. Included
// only by the files that implement Contacts.
#include <momentree/contact/distance.hpp>
#include <momentree/simulate/contacts.hpp>

namespace momentree {

/// At most the distance of a ball from a plane or a height field (m).
inline double above_ground(const Collider& below, const Vec3& centre, double radius) {
  return below.field ? contact::clearance(*below.field, centre, radius) : dot(below.normal, centre - below.point) - radius;
}
/// The distance of a solid from another collider.
inline contact::NearestPoints distance_to(const contact::Solid& solid, const contact::Place& place, const Collider& other,
                                          const contact::Place& of_other) {
  if (other.plane) return contact::distance_to_plane(solid, place, other.point, other.normal);
  return other.field ? contact::distance_to_field(solid, place, *other.field)
                     : contact::distance(solid, place, other.solid, of_other);
}

inline const Vec3& along(const contact::Touch& touch, std::size_t k) { return k == 0 ? touch.normal : touch.tangent[k - 1]; }

/// Gap of a pair of solids that are not in contact, or of further features of a pair that is.
struct Contacts::PairGap : Quantity {
  const Contacts* all;
  int pair;
  double within;
  PairGap(const Contacts& contacts, int number, double near) : all(&contacts), pair(number), within(near) {}
  std::string_view key() const override { return "gap"; }
  const char* summary() const override { return "Gap of two bodies (m)"; }
  void fields(QuantityFields&) override {}
  Dimension dimension() const override { return dimension::length; }
  std::optional<double> value(const World&, std::span<const Event>) const override { return all->gap_of(pair, within).value; }
  std::optional<double> rate(const World&) const override { return all->gap_of(pair, within).rate; }
};

/// Positive where the closed contacts would have to pull, or to exert more friction than they can.
struct Contacts::Hold : Quantity {
  Contacts* all;
  explicit Hold(Contacts& contacts) : all(&contacts) {}
  std::string_view key() const override { return "hold"; }
  const char* summary() const override { return "What contacts lack to stay as they are"; }
  void fields(QuantityFields&) override {}
  Dimension dimension() const override { return dimension::number; }
  std::optional<double> value(const World&, std::span<const Event>) const override { return all->excess_of_forces(); }
};

/// Positive where features of a pair that are in contact no longer face each other: a ball rolls off the edge of a face.
struct Contacts::Leaves : Quantity {
  const Contacts* all;
  int pair;
  Leaves(const Contacts& contacts, int number) : all(&contacts), pair(number) {}
  std::string_view key() const override { return "leaves"; }
  const char* summary() const override { return "Whether features in contact no longer face each other"; }
  void fields(QuantityFields&) override {}
  Dimension dimension() const override { return dimension::number; }
  std::optional<double> value(const World&, std::span<const Event>) const override { return all->face_each_other(pair) ? -1 : 1; }
};

/// Positive where solids that passed through each other are apart.
struct Contacts::Apart : Quantity {
  const Contacts* all;
  int pair;
  Apart(const Contacts& contacts, int number) : all(&contacts), pair(number) {}
  std::string_view key() const override { return "apart"; }
  const char* summary() const override { return "Whether two bodies are apart"; }
  void fields(QuantityFields&) override {}
  Dimension dimension() const override { return dimension::number; }
  std::optional<double> value(const World&, std::span<const Event>) const override { return all->are_apart(pair) ? 1 : -1; }
};

/// Positive where a contact moves against the direction in which it slipped at the start of the step.
struct Contacts::Slip : Quantity {
  const Contacts* all;
  int contact;
  Vec3 direction;
  Slip(const Contacts& contacts, int number, const Vec3& start) : all(&contacts), contact(number), direction(start) {}
  std::string_view key() const override { return "slip"; }
  const char* summary() const override { return "Speed of a contact that slips (m/s)"; }
  void fields(QuantityFields&) override {}
  Dimension dimension() const override { return dimension::speed; }
  std::optional<double> value(const World&, std::span<const Event>) const override {
    return -dot(all->slip_velocity(contact), direction);
  }
};

}  // namespace momentree
