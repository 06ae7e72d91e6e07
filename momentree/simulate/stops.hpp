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
#include <momentree/simulate/topology_editor.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// A condition to be located in a step: when it comes true; where it holds and has to last, when it no longer does; where it is
/// to be armed again, when it is back far enough.
struct Watch {
  const Condition* condition;
  double start;                        ///< its excess now, not positive
  double before = 0, ago = 0;          ///< its value at the last look, and how long ago that was (s); 0: something happened since
  double sign = 1, offset = 0;         ///< what counts is sign·(excess + offset)
  std::optional<double> start_rate{};  ///< its rate now, where its quantity gives one

  /// The same rate where the world stands now.
  std::optional<double> rate(const World& world) const {
    const std::optional<double> found = condition->rate(world);
    return found ? std::optional(sign * *found) : std::nullopt;
  }
};

class Stops {
 public:
  /// Instants are located to `tolerance` seconds.
  Stops(World& world, Evaluator& evaluate, double tolerance) : world_(&world), evaluate_(&evaluate), tolerance_(tolerance) {}

  /// False where no joint has limits: nothing else here needs to be called then.
  bool any();

  /// Deals with what touches a stop now: impacts, rests, releases. One event for each impact, rest and release.
  void resolve_limits(std::vector<Event>& events);

  /// One step of at most h seconds, which ends early where a stop is hit or must let go, or one of `watches` happens. Returns the
  /// seconds stepped, nothing where the method failed (the state is then what it was).
  std::optional<double> step(Integrator& method, EnergyLedger& ledger, double h, std::span<const Watch> watches = {});

  /// Among joints resting on stops, those which transmitted impulses that a stop can't (it would have pulled) at `event`: lets go
  /// of them. False: there is none.
  bool release_pulled(const std::vector<Event>& events);

 private:
  struct Side {
    int joint, dof, sign;  // +1: the upper stop
    double limit, restitution, rest_speed;
    bool left = false;  // within settle()
  };
  struct Trial;
  struct Watched {
    const Side* side = nullptr;      ///< a stop, or else
    const Watch* watch = nullptr;    ///< a condition
    double limit = 0, q = 0, v = 0;  ///< where it counts as crossed; at the start
    bool held = false;
    double last = 0, last_rate = 0;  ///< excess at the end of the step, and its rate; NaN: not known
    double rise = 0, fall = 0;       ///< slopes of a condition without rates, at both ends: find_slopes
  };
  double excess(const Watched& watched) const;
  void look_at_end(std::size_t first);
  bool find_slopes(Trial& trial, double end);
  std::optional<double> crossing(Trial& trial, const Watched& watched, double end);
  std::optional<double> peak(Trial& trial, const Watched& watched, double end);
  void put_on_stop(const Watched& watched);
  void find();
  double coordinate(const Side& side) const;
  double speed(const Side& side) const;         // towards the stop
  double acceleration(const Side& side) const;  // towards the stop; the work is accelerated
  double pull(const Side& side) const;          // force with which the stop would have to pull
  double rest_speed(const Side& side) const;    // what hits the stop no faster rests; the work is accelerated
  bool holds(const Side& side) const;
  bool locked(const Side& side) const;
  bool one_thing(std::vector<Event>& events);
  enum class LimitEvent { hit, rest, leave };
  void act(std::vector<Event>& events, const Side& side, LimitEvent deed, double restitution);

  /// Speeds below this fraction of rest_speed count as zero.
  static constexpr double no_speed = 1e-6;

  World* world_;
  Evaluator* evaluate_;
  double tolerance_;  // s
  std::vector<Side> sides_;
  // Of one step, kept so that the next one allocates nothing.
  std::vector<Watched> watched_;
  double slopes_of_ = 0;  // the end of the step that slopes were found for
  State start_;
  std::optional<std::uint64_t> revision_;
};

}  // namespace momentree
