#pragma once
// Pushes bodies apart that overlap at the start, with the least motion.
#include <vector>

#include <momentree/contact/many_points.hpp>
#include <momentree/dynamics/contacts/contact_parts.hpp>
#include <momentree/simulate/stepping/pair_overlaps.hpp>

namespace momentree {

/// The motion is the least one that removes the overlaps, in the metric of the mass matrix: overlaps are linearised again after
/// each try, and the next one is the least motion from the start. Where that does not converge, because the nearest way out
/// changes, later tries remove what is left from where the bodies are. Joints stay within their hard stops.
class Separator {
 public:
  explicit Separator(const ContactGeometry& geometry) : geometry_(&geometry), world_(&geometry.world) {}
  Separation run();
  /// At the start of a model.
  static Separation of(const Model& model);

 private:
  double find_points(double within);
  double find_step(bool from_start);
  void take_step(double part);
  void add_stops();
  double beyond_stops() const;
  std::vector<Vec3> centres() const;
  std::optional<Overlap> what_is_left() const;

  const ContactGeometry* geometry_;
  const ContactWorld* world_;
  ContactParts parts_;
  MomentumKeepingDisplacement displacement_;
  std::vector<Contact> near_;
  ContactRows rows_;
  contact::ManyPoints many_;
  double size_ = 1;                   // of coordinates (m)
  std::vector<double> moved_, step_;  // since the start, and next, packed as p
  std::vector<double> gaps_, pushes_;
};

}  // namespace momentree
