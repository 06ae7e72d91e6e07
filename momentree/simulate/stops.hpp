#pragma once
// Hard stops of joints (JointLimits): when they are hit, how they throw back, how a joint rests on one and leaves it again.
//
// A stop pushes and never pulls. Hit faster than its rest speed, the joint's freedom is thrown back with its restitution; slower,
// it rests: the freedom is locked, until the stop would have to pull to hold it.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/condition.hpp>
#include <momentree/simulate/surgery.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// A condition to be located in a step: when it comes true; where it holds and has to last, when it no longer does; where it is
/// to be armed again, when it is back far enough.
struct Watch {
  const Condition* condition;
  double start;                 ///< its excess now, not positive
  double before = 0, ago = 0;   ///< its value at the last look, and how long ago that was (s); 0: something happened since
  double sign = 1, offset = 0;  ///< what counts is sign·(excess + offset)
};

class Stops {
 public:
  Stops(World& world, Evaluator& evaluate) : world_(&world), evaluate_(&evaluate) {}

  /// False where no joint has limits: nothing else here needs to be called then.
  bool any();

  /// Deals with what touches a stop now: impacts, rests, releases. One event for each impact, rest and release.
  void settle(std::vector<Event>& events);

  /// One step of at most h seconds, which ends early where a stop is hit or must let go, or one of `watches` happens, located to
  /// `tolerance` seconds. Returns the seconds stepped, nothing where the method failed (the state is then what it was).
  std::optional<double> step(Integrator& method, Books& books, double h, double tolerance, std::span<const Watch> watches = {});

  /// Among joints resting on stops, those which transmitted impulses that a stop can't (it would have pulled) at `event`: lets go
  /// of them. False: there is none.
  bool release_pulled(const std::vector<Event>& events);

 private:
  struct Side {
    int joint, freedom, sign;  // +1: the upper stop
    double limit, restitution, rest_speed;
  };
  struct Trial;
  struct Watched {
    const Side* side = nullptr;      ///< a stop, or else
    const Watch* watch = nullptr;    ///< a condition
    double limit = 0, q = 0, v = 0;  ///< where it counts as crossed; at the start
    bool held = false;
  };
  double excess(const Watched& watched) const;
  std::optional<double> crossing(Trial& trial, const Watched& watched, double end, double tolerance) const;
  std::optional<double> peak(Trial& trial, const Watched& watched, double end) const;
  void find();
  double coordinate(const Side& side) const;
  double speed(const Side& side) const;         // towards the stop
  double acceleration(const Side& side) const;  // towards the stop; the work is accelerated
  double pull(const Side& side) const;          // force with which the stop would have to pull
  bool holds(const Side& side) const;
  bool locked(const Side& side) const;
  bool one_thing(std::vector<Event>& events);
  enum class Deed { hit, rest, leave };
  void act(std::vector<Event>& events, const Side& side, Deed deed, double restitution);

  World* world_;
  Evaluator* evaluate_;
  std::vector<Side> sides_;
  // Of one step, kept so that the next one allocates nothing.
  std::vector<Watched> watched_;
  State start_;
  std::optional<std::uint64_t> revision_;
};

}  // namespace momentree
