#pragma once
// Pairs of solids, and cables: which of them can touch, how far apart they are, and how fast they approach each other.
#include <cmath>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/contact/broad_phase.hpp>
#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>
#include <momentree/contact/shapes/overlap_points.hpp>
#include <momentree/simulate/contact/contact_world.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree {

struct ContactPair {
  const Collider *one = nullptr, *other = nullptr;  ///< none of a cable
  int a = -1, b = -1;                               ///< bodies; the ground is the second one
  ContactLaw law{};
  bool while_joined = false;    ///< they also touch while a joint connects them
  double thickness = HUGE_VAL;  ///< of the thinner one; infinite with a plane
  std::string law_name{};
  int cable = -1;  ///< its number as a spring; −1: two solids
  bool has_plane() const { return cable < 0 && other->plane; }
  bool polyhedra() const { return cable < 0 && !other->plane && !one->solid.faces.empty() && !other->solid.faces.empty(); }
};

/// At most the distance of a ball from a plane or a height field (m).
double above_ground(const Collider& below, const Vec3& centre, double radius);
/// A lower bound of the distance of two solids, the second of which may be a plane or a height field (m).
double apart(const Collider& one, const contact::Place& a, const Collider& other, const contact::Place& b);
contact::NearestPoints distance_to(const contact::Solid& solid, const contact::Place& place, const Collider& other,
                                   const contact::Place& of_other);

/// Pairs have numbers: that of the first collider times the largest number of colliders, plus that of the second one. After these
/// come cables in the order of the model's springs. Colliders that are added to the world change no numbers.
class ContactPairs {
 public:
  explicit ContactPairs(const ContactWorld& world) : world_(&world) {}

  /// False if no bodies can touch: nothing else of contacts needs to be called then.
  bool any() const;
  /// To be called after bodies that can touch were added to the world or left it.
  void renew() { bodies_ = -1; }
  const ContactPair& operator[](int number) const;
  const ContactLaw& law(int number) const { return (*this)[number].law; }
  /// Pairs that can touch within h seconds, or are nearer than `margin` (m), in ascending order; and all cables. Valid until the
  /// next call.
  const std::vector<int>& near(double h, double margin) const;

  /// Of coordinates, for tolerances (m).
  double size(const ContactPair& pair) const { return std::max(1.0, norm(world_->place(pair.a).r)); }
  /// A lower bound of the distance of two solids, or by how much a cable is slack (m).
  double apart(const ContactPair& pair) const;
  /// An upper bound of the speed with which points of two solids approach each other, or the ends of a cable part (m/s).
  double speed_bound(const ContactPair& pair) const;
  /// How far a solid may move towards another one: not farther than through a part of the thinner one, so that its end is not
  /// beyond it (m).
  double margin(const ContactPair& pair) const;
  /// How near features are whose gap is watched, and how deep they may overlap (m).
  static double looked_within(const ContactPair& pair);
  /// A time (s) within which a pair does not come near and leave again unseen.
  double longest_step(const ContactPair& pair, double distance, double speed, double acceleration) const;
  /// How far rounding may be off in a gap (m).
  double rounding(const ContactPair& pair) const;

  /// Features that are nearer than `within` (m). Valid until the next call.
  const std::vector<contact::Candidate>& candidates(const ContactPair& pair, double within) const;
  Contact contact_of(int number, const contact::Candidate& candidate) const;
  /// Appends their contacts.
  void add(int number, double within, std::vector<Contact>& out) const;
  /// The same, or if the solids are polyhedra that may overlap, the points at which they do.
  void add_overlapping(int number, double within, std::vector<Contact>& out) const;
  struct Gap {
    double value, rate;
  };
  /// Negative where the solids of a pair overlap, apart from contacts that are closed; `within` if nothing is that near.
  Gap gap(int number, double within) const;
  /// True if the features of a pair that are in contact are still those that touch.
  bool still_face(int number) const;
  /// How deep a pair overlaps (m), also where bodies cross each other so that no feature of one is inside the other.
  double depth(int number) const;
  contact::NearestPoints nearest(const ContactPair& pair) const;
  bool are_apart(int number) const;

 private:
  void find_any() const;
  void add_if_near(int one, int other) const;
  contact::Features features_of(const ContactPair& cable) const;
  double time_to_stand(const ContactPair& pair, double acceleration) const;

  const ContactWorld* world_;
  mutable int bodies_ = -1;                             // of the model when any_ was found
  mutable bool any_ = false;                            // two bodies can touch
  mutable std::unordered_map<int, ContactPair> known_;  // those that were near so far
  mutable contact::BroadPhase broad_phase_;
  mutable contact::OverlapPoints overlap_;
  mutable std::vector<contact::Ball> balls_;
  mutable std::vector<int> near_, solids_;
  mutable std::vector<contact::Candidate> found_;
};

}  // namespace momentree
