#pragma once
// Hard stops of joints (JointLimits): impact, rebound, and how a joint comes to rest on a stop and leaves it again.
//
// A stop pushes and never pulls. If a joint hits it faster than its rest speed, the DoF rebounds with its restitution; if it hits
// more slowly, it rests: the DoF is locked until the stop would have to pull to hold it.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/world/topology_editor.hpp>
#include <momentree/simulate/world/world_edit.hpp>

namespace momentree {

/// A condition to be located within a step: when it is met; for a condition that holds and has to last, when it ceases to hold;
/// for a condition to be armed again, when the quantity is back far enough.
struct Watch {
  const Condition* condition;
  double start;                        ///< its excess now, not positive
  double before = 0, ago = 0;          ///< its value at the last evaluation, and the time since then (s); 0: an event happened
                                       ///< since
  double sign = 1, offset = 0;         ///< the located function is sign·(excess + offset)
  std::optional<double> start_rate{};  ///< its rate now, if its quantity provides one
  bool precise = false;                ///< located to within rounding, by its rate

  /// That rate in the present state of the world.
  std::optional<double> rate(const World& world) const {
    const std::optional<double> found = condition->rate(world);
    return found ? std::optional(sign * *found) : std::nullopt;
  }
};

class ContactSteps;
struct SteppedStop;

class Stops {
 public:
  /// Instants are located to `tolerance` seconds.
  Stops(World& world, Evaluator& evaluate, double tolerance) : world_(&world), evaluate_(&evaluate), tolerance_(tolerance) {}

  /// False if no joint has limits: no other function of this class needs to be called then.
  bool any();
  /// The number of stops.
  std::size_t count() { return any() ? sides_.size() : 0; }

  /// Resolves the present contacts with stops: impacts, rests, releases, one event for each.
  void resolve_limits(std::vector<Event>& events);

  /// Joints that hit stops at present, faster than their rest speeds, rebound, or rest on stops without restitution, whatever
  /// other stops transmit. False: there are none.
  bool strike(std::vector<Event>& events);
  /// True if strike() would find any.
  bool would_strike() { return any() && fastest_hit() != nullptr; }

  /// One step of at most h seconds, which ends early if a stop is hit or must release its joint, or one of `watches` fires.
  /// Returns the length of the step (s), or nothing if the method failed (the state is then restored).
  std::optional<double> step(Integrator& method, EnergyLedger& ledger, double h, std::span<const Watch> watches = {});

  /// What solves stops with the contacts, of joints of the tree whose contacts it steps through. Their DoFs are not locked.
  void use(ContactSteps& steps) { steps_ = &steps; }
  /// Gives it the stops of these joints. Those that rest on stops are unlocked there, and locked where contacts are located
  /// again.
  void share();
  /// The events of these stops in the last step.
  void report_stepped(std::vector<Event>& events);

  /// Releases the joints resting on stops that transmitted impulses at `happened` which a stop cannot exert (it would have
  /// pulled), and with `pressed` those that transmitted any, with an event of each. False: there are none.
  bool release_pulled(const std::vector<Event>& happened, std::vector<Event>& events, bool pressed = false);
  /// Releases the joints that these joint forces, packed as p, push off their stops. False: there are none.
  bool release_pushed(const std::vector<double>& forces, std::vector<Event>& events);

  /// The joint that a stop can't stop at present, because nothing that it moves can give way; −1: none.
  int blocked() const { return blocked_; }

  /// Joints of which a stop did not hold: "'arm' is 0.1 beyond its upper stop".
  std::vector<std::string> passed() const;

  /// Those that act deeper, which belong to the state of a run.
  std::vector<DeeperStop> deeper() const;
  void set_deeper(std::span<const DeeperStop> stops);

 private:
  struct Side {
    int joint, dof, sign;  // +1: the upper stop
    double limit, restitution, rest_speed;
    double edge = -HUGE_VAL;  // sign times the coordinate at which it acts, if that is beyond its limit: leave()
  };
  struct Trial;
  struct Watched {
    const Side* side = nullptr;      ///< a stop, or else
    const Watch* watch = nullptr;    ///< a condition
    double limit = 0, q = 0, v = 0;  ///< the crossing level; position (of a held joint the pull) and velocity at the start
    bool held = false;
    double last = 0, last_rate = 0;  ///< excess at the end of the step, and its rate; NaN: unknown
    double rise = 0, fall = 0;       ///< slopes at both ends of a condition without rates: find_slopes
    /// The excess at the start of the step.
    double start() const { return watch != nullptr ? watch->start : q - limit; }
    /// Its rates at both ends of the step; NaN: unknown.
    std::pair<double, double> rates() const {
      if (held) return {NAN, NAN};
      return {watch == nullptr ? v : watch->start_rate.value_or(NAN), last_rate};
    }
  };
  double excess(const Watched& watched) const;
  void look_at_end(std::size_t first);
  bool find_slopes(Trial& trial, double end);
  std::optional<double> crossing(Trial& trial, const Watched& watched, double end);
  /// A part of a step, and the excess at its ends.
  struct Part {
    double from, to, first, last;
  };
  std::optional<double> search(Trial& trial, const Watched& watched, const Part& part, int least_depth, int& samples);
  std::optional<double> peak(Trial& trial, const Watched& watched, double end);
  void put_on_stop(const Watched& watched);
  void make_deeper(std::span<const DeeperStop> stops);
  void find();
  double coordinate(const Side& side) const;
  static double rounding(const Side& side);     // of the coordinate at the stop
  double speed(const Side& side) const;         // towards the stop
  double acceleration(const Side& side) const;  // towards the stop; the workspace holds accelerations
  bool is_stepped(const Side& side) const;
  bool stands(const Side& side) const;  // as exactly as steps through contacts see it
  SteppedStop as_stop(const Side& side) const;
  double pull(const Side& side) const;        // force with which the stop would have to pull
  double rest_speed(const Side& side) const;  // slower impacts come to rest; the workspace holds accelerations
  bool holds(const Side& side) const;
  bool locked(const Side& side) const;
  bool touches(const Side& side) const;
  double edge(const Side& side) const { return std::max(side.sign * side.limit, side.edge); }
  bool at_stop(const Side& side) const;
  void leave(std::vector<Event>& events, Side& side);
  const Side* fastest_hit();
  bool one_thing(std::vector<Event>& events);
  enum class LimitEvent { hit, rest, leave };
  Event begin_event(const Side& side, LimitEvent deed) const;
  void act(std::vector<Event>& events, const Side& side, LimitEvent deed, double restitution);

  /// Speeds below this fraction of rest_speed count as zero.
  static constexpr double no_speed = 1e-6;

  State& state() const { return world_->edit().state(); }
  Workspace<double>& workspace() const { return world_->edit().workspace(); }

  World* world_;
  Evaluator* evaluate_;
  double tolerance_;  // s
  ContactSteps* steps_ = nullptr;
  std::vector<Side> sides_;
  int blocked_ = -1;
  // Buffers of one step, kept so that the next step allocates nothing.
  std::vector<Watched> watched_;
  double slopes_of_ = 0;  // the end of the step for which the slopes were found
  State start_, end_;
  std::optional<std::uint64_t> revision_;
};

}  // namespace momentree
