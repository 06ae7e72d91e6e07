#pragma once
// Contacts of bodies: what happens at the instants at which they touch, and which of them stay closed afterwards, sticking or
// slipping.
//
// Contacts press and never pull. Within a step the instant is located at which two bodies touch, a contact would have to pull, or
// it begins to slip or to stick. There all contacts that touch take part in one impact, if they approach; then a complementarity
// problem in the accelerations tells which of them stay closed, and how.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/simulate/contact/contact_choice.hpp>
#include <momentree/simulate/contact/contact_events.hpp>
#include <momentree/simulate/contact/contact_impacts.hpp>
#include <momentree/simulate/contact/contact_watches.hpp>
#include <momentree/simulate/stepping/pair_overlaps.hpp>

namespace momentree {

class Contacts {
 public:
  /// Instants are located to `tolerance` seconds. `step`: the length of steps (s); 0: the method adapts them.
  Contacts(const ContactGeometry& geometry, double tolerance, contact::Simultaneous how, double step);
  Contacts(const Contacts&) = delete;
  Contacts& operator=(const Contacts&) = delete;

  /// Why an instant can't be resolved.
  struct Unresolved {
    std::string why;
    std::vector<int> bodies{};   ///< of the island for which that is true
    bool can_be_stepped = true;  ///< time stepping continues from there
  };
  /// Resolves the present instant: impacts, and which contacts are closed from now on.
  std::optional<Unresolved> resolve(std::vector<Event>& events);
  /// Energy (J) that contacts took since the last call, at instants without an event, from velocities too slow to be followed.
  double take_lost() { return std::exchange(lost_, 0.0); }

  /// The joint forces, packed as p, of unit forces at points that approach each other although no impulse can change that.
  std::vector<double> rigid_pushes() const;

  ContactWatches watches;

 private:
  SlowMotion slow() const { return {watches.slow_slip(), 0}; }
  std::vector<Contact> take_former();
  std::optional<Unresolved> strike(const std::vector<Contact>& touching, std::vector<Event>& events);
  std::optional<Unresolved> close(std::vector<std::vector<Contact>> islands, const std::vector<Contact>& before,
                                  StoppedMotion& stopped, std::map<int, Vec3>& impulses);
  bool choose(std::vector<Contact>& touching, const std::vector<Contact>& before, const ContactsByPair& before_by_pair,
              StoppedMotion& stopped, std::vector<Contact>& closed);
  void stop_creeping(std::vector<Contact> contacts, StoppedMotion& stopped);
  void report_changes(const std::vector<Contact>& before, std::size_t first, const std::map<int, Vec3>& impulses,
                      std::vector<Event>& events) const;

  const ContactGeometry* geometry_;
  ContactEvents events_;
  ContactChoice choice_;
  ContactImpacts impacts_;
  double lost_ = 0;
};

}  // namespace momentree
