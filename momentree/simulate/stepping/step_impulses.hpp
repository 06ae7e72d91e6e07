#pragma once
// The impulses of a step through contacts: at the points that bodies have reached, or are near, and at the hard stops of joints.
#include <cstdint>
#include <vector>

#include <momentree/contact/many_points.hpp>
#include <momentree/dynamics/contacts/contact_parts.hpp>
#include <momentree/simulate/stepping/stepped_pairs.hpp>
#include <momentree/simulate/stepping/stepping_state.hpp>

namespace momentree {

/// A hard stop of a joint of the tree, which takes part in the impulses of the next steps as a further point.
struct SteppedStop {
  int joint, body, dof, sign;  ///< sign 1: the upper stop
  double limit, restitution, rest_speed;
  bool touched;        ///< the joint is there at the start of the step, and does not move away
  bool rests = false;  ///< it rests there
  double force = 0;    ///< in the step before (N or N m)
};
SteppedContact point_of(const SteppedStop& stop, double force);

class StepImpulses {
 public:
  StepImpulses(const ContactWorld& world, const ContactPairs& pairs, const SteppedPairs& stepped)
      : world_(&world), pairs_(&pairs), stepped_(&stepped) {}

  struct NearStop {
    SteppedStop stop;
    double gap, velocity, acceleration;  ///< as those of points
  };
  std::vector<Contact> near;    ///< pairs of features; first of all points
  std::vector<NearStop> stops;  ///< the next points; the last ones are moments of contacts
  ContactRows rows;             ///< of `near`
  ContactParts parts;
  contact::ManyPoints many;
  std::vector<double> reached;  ///< by point: the time since it was reached (s)
  std::vector<double> after;    ///< velocities after the impulses, three of each point
  std::vector<int> hits;        ///< the bodies that hit others in the step, rather than to lie on them

  /// Of all stops, those that joints have reached, or are nearer to than they move in h seconds.
  void find_stops(const std::vector<SteppedStop>& all, double h);
  /// The points of solids that overlap, or are nearer than `within`. The state has been evaluated without contacts.
  void find_points(double within, const std::vector<bool>& stays);
  bool any() const { return !near.empty() || !stops.empty(); }
  /// Finds the impulses of a step of h seconds. `before`: the forces of the last step.
  void solve(const std::vector<SteppedContact>& before, double h);
  /// True if prescribed motions press together what contacts and stops keep apart. Stops then give way, which a warning says.
  bool jammed();
  /// Points that bounce are then as if they were reached at the end of the step.
  void forget_bounces();
  /// True if a stop was hit.
  bool struck(int joint, int dof, int sign) const;
  void forget_hits() { hit_.clear(); }

  /// The impulses of a step of h seconds that begins with the present accelerations, as forces.
  std::vector<SteppedContact> forces_from_rest(const std::vector<SteppedContact>& before, double h);
  /// Appends the means of the forces in this step and in the time before it, in which they were as before, over `usual` seconds,
  /// in order: those of stops first.
  void add_means(const std::vector<SteppedContact>& before, double h, double usual, std::vector<SteppedContact>& out);

 private:
  struct Moments {
    std::size_t contact, point;  ///< numbers in `near` and in `many`
    double length;               ///< of its unit impulses (m)
  };
  void find_moments();
  void share_times();
  const Moments* moments_of(std::size_t contact) const;
  void guess(const std::vector<SteppedContact>& before, double h);
  bool approach(std::size_t point, double gap, double v, double a, double restitution, double slow, double h);
  void set_law(double h);
  bool lay_there(double v, double a, double h) const;
  SteppedContact point_at(std::size_t i, const Vec3& force, const std::vector<double>& velocity) const;
  void add_moment(std::size_t i, double before, double over, SteppedContact& point) const;

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  const SteppedPairs* stepped_;
  std::vector<bool> hit_;         // by point: it was hit in the step
  std::vector<double> carried_;   // by point: three components of the force before (N)
  std::vector<Moments> moments_;  // in ascending order; their points are those after stops
};

}  // namespace momentree
