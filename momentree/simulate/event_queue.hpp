#pragma once
// What is to happen: events with their instants or conditions, and what became of them so far.
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/instant.hpp>
#include <momentree/simulate/stops.hpp>
#include <momentree/simulate/strengths.hpp>

namespace momentree {

/// How near a condition came to being true: the largest excess over its threshold at any look, negative where it never was; a
/// peak between looks by the parabola through three of them.
struct Approach {
  double excess = -HUGE_VAL, time = 0;  ///< −infinity: there was nothing to look at
  double held = 0;                      ///< the longest that it held without a gap (s)

  void look(double time_now, double excess_now) {
    if (excess_now > excess) excess = excess_now, time = time_now;
  }
};

class EventQueue {
 public:
  struct Entry {
    DueEvent event;
    double time = HUGE_VAL;              ///< when it is due, as far as that is known
    std::optional<Condition> condition;  ///< or when it comes true
    std::string after;                   ///< or after the event of that name,
    double delay = 0;                    ///< by this (s)
    double period = 0;                   ///< and again every so often (s); 0: once
    std::size_t rank = 0;                ///< of what is due at one instant the lowest comes first
    int fired = 0;
    bool done = false;
    double since = -1;                                                      ///< since when the condition holds, −1: it does not
    bool resting = false;                                                   ///< it repeats, and is not armed again yet
    double excess = 0, excess_before = 0, looked = -1, looked_before = -1;  ///< at the last two looks, and when; −1: none
    Approach nearest;                                                       ///< since the start or the last restore
  };

  /// When an entry would happen, as far as that is known.
  struct Turn {
    double time;
    bool follows;  ///< another one, without a delay: an instant of its own, at the same time
    std::size_t entry;
  };

  std::vector<Entry> entries;      ///< in the order of scheduling
  std::set<std::string> expected;  ///< names of joints that events will make
  /// Places past `entries` are entries of the strengths of joints, valid until the world next changes.
  Entry& at(std::size_t place) { return place < entries.size() ? entries[place] : strengths_[place - entries.size()].entry; }

  /// Adds an entry and finds the next instant; returns its place.
  std::size_t add(Entry entry);
  /// The next instant at which something may be due.
  double next_time() const { return next_; }
  void look_ahead();

  /// Places of what is due at an instant, or was.
  std::vector<std::size_t> due(double time) const;
  /// The condition that is true now and comes first: the largest ratio of load to threshold, else the first scheduled. Keeps
  /// account of since when conditions hold.
  std::optional<std::size_t> urgent(const World& world, std::span<const Event> now);
  /// What is to be located in the next step; good until the next call and the next entry.
  std::span<const Watch> watches(const World& world);
  /// True where conditions are to be looked at after a step.
  bool watching(const World& world) const;

  /// The world changed at this instant: what conditions look at may have jumped, and no parabola goes through that.
  void forget_looks();
  /// An entry happened: it is done, or armed again; what follows it has its instant now.
  void happened(std::size_t place, double time);

  /// By entry, what a snapshot keeps of it.
  struct Armed {
    double time = 0;
    int fired = 0;
    bool done = false;
    double since = -1;
    bool resting = false;
    double excess = 0, excess_before = 0, looked = -1, looked_before = -1;
    friend bool operator==(const Armed&, const Armed&) = default;
  };
  std::vector<Armed> armed() const;
  /// Entries that the list does not have stay scheduled where they are not past at `now`.
  void restore(std::span<const Armed> armed, double now);

 private:
  struct Borne {
    Strength strength;
    Entry entry;
  };
  void renew_strengths(const World& world);
  std::size_t count() const { return entries.size() + strengths_.size(); }

  double next_ = HUGE_VAL;
  std::vector<Watch> watches_;
  std::vector<Borne> strengths_;
  std::optional<std::uint64_t> strengths_of_;  // of which revision of the tree
};

}  // namespace momentree
