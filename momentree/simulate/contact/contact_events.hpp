#pragma once
// Events at contacts, and the impulses that are part of them.
#include <map>
#include <span>
#include <string>
#include <vector>

#include <momentree/simulate/contact/contact_choice.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree {

class ContactEvents {
 public:
  ContactEvents(const ContactWorld& world, const ContactPairs& pairs) : world_(&world), pairs_(&pairs) {}

  Event begin(const char* what, int pair) const;
  /// Point and normal of several contacts that are placed, of one pair, each with a weight.
  void locate(Event& event, const std::vector<Contact>& contacts, const ContactRows& rows, const std::vector<double>& weights,
              int pair) const;

  struct Impulses {
    std::vector<double> generalised;  // packed as p
    std::vector<AppliedImpulse> on_bodies, on_ground;
    std::map<int, Vec3> by_pair;  // on its first body
  };
  /// Of impulses r along the rows of contacts that are placed.
  Impulses impulses(const std::vector<Contact>& contacts, const ContactRows& rows, const std::vector<double>& r) const;
  /// Applies them as part of an event.
  void apply(const Impulses& impulses, const ContactRows& rows, const std::vector<double>& r, TopologyEditor& editor,
             Event& event) const;

 private:
  std::string name(const char* what, const ContactPair& pair) const;

  const ContactWorld* world_;
  const ContactPairs* pairs_;
};

/// What happens to bodies that needs no event of its own, such as the end of slow slip: part of another event of the instant.
class StoppedMotion {
 public:
  explicit StoppedMotion(const ContactWorld& world, const ContactEvents& events)
      : world_(&world), events_(&events), editor_(world.world()) {}

  /// Removes what is left of the velocities that closed contacts do not allow; returns the impulses of pairs. Slow approaches
  /// are not felt.
  std::map<int, Vec3> stop(const std::vector<Contact>& closed, const SlowMotion& slow);
  /// Makes it part of one of the events of the instant, from `first` on: of the first one from `changes` on, or else of the last
  /// one before.
  void join(std::vector<Event>& events, std::size_t first, std::size_t changes);
  /// Energy (J) that this took and that no event has.
  double lost() const { return lost_ + (joined_ ? 0 : event_.lost - event_.work); }

 private:
  const ContactWorld* world_;
  const ContactEvents* events_;
  TopologyEditor editor_;
  Event event_{};
  bool any_ = false, joined_ = false;
  double lost_ = 0;
};

}  // namespace momentree
