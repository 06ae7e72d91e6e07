#pragma once
// The event queue: scheduled events with their instants or conditions, and their status.
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/events/instant.hpp>
#include <momentree/simulate/events/stops.hpp>
#include <momentree/simulate/events/strengths.hpp>

namespace momentree {

/// How near a condition came to firing: the largest excess over its threshold at any evaluation, negative if it never held. A
/// peak between evaluations is estimated by the parabola through three of them.
struct Approach {
  double excess = -HUGE_VAL, time = 0;  ///< −infinity: the quantity never had a value
  double held = 0;                      ///< the longest time that it held without interruption (s)

  void note(double time_now, double excess_now) {
    if (excess_now > excess) excess = excess_now, time = time_now;
  }
};

struct QueueState;

class EventQueue {
 public:
  /// What a run changes in an entry.
  struct Progress : EventStatus {
    Approach nearest{};  ///< since the start or the last restore
  };
  struct Entry : Progress {
    Entry() { time = HUGE_VAL; }
    DueEvent event;
    std::optional<Condition> condition;  ///< or when this condition is met
    std::string after;                   ///< or after the event with that name,
    double delay = 0;                    ///< by this delay (s)
    double period = 0;                   ///< repeated with this period (s); 0: once
    double from = 0;                     ///< the first instant of a repeated one (s)
    std::size_t rank = 0;                ///< of the entries due at one instant, the lowest rank comes first
  };

  /// When an entry would happen, if known.
  struct Turn {
    double time;
    bool follows;  ///< follows another event without a delay: an instant of its own, at the same time
    std::size_t entry;
  };

  std::vector<Entry> entries;      ///< in the order of scheduling
  std::set<std::string> expected;  ///< names of joints that events will make
  /// Places past `entries` are the entries of joint strengths, valid until the world next changes.
  Entry& at(std::size_t place) { return place < entries.size() ? entries[place] : strengths_[place - entries.size()].entry; }

  /// The number of entries, with those of joint strengths.
  std::size_t count() const { return entries.size() + strengths_.size(); }

  /// Adds an entry, updates the next instant and returns the entry's place.
  std::size_t add(Entry entry);
  /// The next instant at which something may be due (s).
  double next_time() const { return next_; }
  void look_ahead();
  /// The entry that will make a joint of that name, which no entry has made yet; null: there is none.
  const Entry* to_make(const std::string& joint) const;

  /// Places of the entries due at an instant or before it.
  std::vector<std::size_t> due(double time) const;
  /// The condition that holds now and comes first: the one with the largest ratio of load to threshold, otherwise the first
  /// scheduled. Updates the times since which conditions hold.
  std::optional<std::size_t> urgent(const World& world, std::span<const Event> now);
  /// The conditions to be located in the next step; valid until the next call and until an entry is added.
  std::span<const Watch> watches(const World& world);
  /// True if conditions are to be evaluated after a step.
  bool watching(const World& world) const;

  /// Call when the world has changed at this instant: quantities may have jumped, so no parabola may be fitted across it.
  void forget_looks();
  /// An entry happened: it is done or armed again; the times of entries that follow it are now known.
  void happened(std::size_t place, double time);

  /// The status of each entry, for a snapshot.
  std::vector<EventStatus> armed() const;
  /// Entries that are not in the list stay scheduled unless their time is before `now`.
  void restore(std::span<const EventStatus> armed, double now);
  /// The status of strengths, after restore().
  void restore_strengths(const QueueState& state, const World& world);
  /// The complete state of the queue in this world.
  QueueState state(const World& world) const;
  /// Continues from it; the same entries must be scheduled, and the world restored.
  void continue_from(const QueueState& state, const World& world);
  /// The clock is set from `before` to `now` (s), and the state may have jumped. Entries whose time is past are done; if the
  /// clock is set back, all others can happen again.
  void restart(double before, double now);

 private:
  struct Borne {
    Strength strength;
    Entry entry;
    std::string joint;  // its name
  };
  static Borne borne(const Strength& strength, const std::string& event, const std::string& joint);
  void renew_strengths(const World& world);

  double next_ = HUGE_VAL;
  std::vector<Watch> watches_;
  std::vector<Borne> strengths_;
  std::optional<std::uint64_t> strengths_of_;  // revision of the tree for which they were found
};

}  // namespace momentree
