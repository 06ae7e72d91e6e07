#pragma once
// Which contacts stay closed, and whether they stick or slip: from a complementarity problem in the accelerations.
#include <vector>

#include <momentree/contact/system.hpp>
#include <momentree/simulate/contact/contact_pairs.hpp>

namespace momentree {

/// Motion that is too slow to count.
struct SlowMotion {
  double slip = slowest_slip;  ///< slower contacts have no direction of slip (m/s)
  double approach = 0;         ///< slower approaches count as rest (m/s)
};
/// Approaches that are slower than this are none (m/s).
double slow_approach(const ContactWorld& world, const SlowMotion& slow);

/// The coefficient of a contact in its mode.
double friction_of(const ContactLaw& law, const Contact& contact);

class ContactChoice {
 public:
  /// `step`: the length of steps (s); 0: the method adapts them.
  ContactChoice(const ContactWorld& world, const ContactPairs& pairs, double step)
      : world_(&world), pairs_(&pairs), step_(step) {}

  /// Which of the contacts that touch, and do not separate, stay closed. False: no forces were found.
  bool choose(const std::vector<Contact>& touching, const SlowMotion& slow, std::vector<Contact>& closed);
  /// The forces of contacts that are placed; null: none were found. They are valid until the next call.
  const std::vector<double>* forces(const std::vector<Contact>& contacts, ContactRows rows, const SlowMotion& slow);
  /// Pairs that no finite force lets slip (Painlevé), since forget_jams().
  bool jams(int pair) const;
  void forget_jams() { jammed_.clear(); }

 private:
  bool choose(std::vector<Contact>& staying, std::size_t i, bool rests, std::vector<Contact>& closed);
  bool slips(const Contact& c, const Vec3& v) const;
  Vec3 slip_at(std::size_t i) const;
  double turning_at(std::size_t i) const;
  bool can_rest(std::vector<Contact> contacts);
  void set_law(const std::vector<Contact>& contacts);
  bool solve(const std::vector<Contact>& contacts);
  void weaken_friction();
  bool solve_weakened(double part, std::vector<double>& all);
  bool uses_nearly_all(const std::vector<Contact>& contacts, std::size_t i) const;
  bool moves_along(const std::vector<Contact>& contacts, std::size_t i) const;

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  double step_;
  SlowMotion slow_;
  ContactRows rows_;
  contact::System system_;
  std::vector<double> after_, weaker_, much_weaker_;  // accelerations; with a little less, and with less friction
  bool weakened_ = false;
  std::vector<int> jammed_;
};

}  // namespace momentree
