#pragma once
// Impacts at contacts, all that touch at once.
#include <optional>
#include <string>
#include <vector>

#include <momentree/contact/impact.hpp>
#include <momentree/simulate/contact/contact_choice.hpp>
#include <momentree/simulate/contact/contact_events.hpp>

namespace momentree {

class ContactImpacts {
 public:
  /// Instants are located to `tolerance` seconds. `usual_step`: the length of steps (s).
  ContactImpacts(const ContactWorld& world, const ContactPairs& pairs, const ContactEvents& events, ContactChoice& choice,
                 double tolerance, double usual_step, contact::Simultaneous how)
      : world_(&world),
        pairs_(&pairs),
        events_(&events),
        choice_(&choice),
        tolerance_(tolerance),
        usual_step_(usual_step),
        simultaneous_(how) {}

  /// The impacts of contacts of one island, one after the other. The result is empty, or why there is no solution.
  std::string strike(const std::vector<Contact>& touching, const SlowMotion& slow, std::vector<Event>& events);
  /// When the bounces of a pair end that were too low or too short to be followed (s), since forget_bounces().
  std::optional<double> settles(int pair) const;
  void forget_bounces() { settling_.clear(); }

 private:
  bool strike_once(const std::vector<Contact>& contacts, const SlowMotion& slow, std::vector<Event>& events,
                   std::string& failure);
  std::vector<double> accelerations_on_others(const std::vector<Contact>& contacts, const SlowMotion& slow, double least);
  double restitution(const Contact& c, double approach, double acceleration);

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  const ContactEvents* events_;
  ContactChoice* choice_;
  double tolerance_, usual_step_;
  contact::Simultaneous simultaneous_;
  ContactRows rows_;
  contact::System system_;
  contact::ImpactLaw law_;
  std::vector<double> restitution_;
  std::vector<std::pair<int, double>> settling_;  // pairs, and when
};

}  // namespace momentree
