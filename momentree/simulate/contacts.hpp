#pragma once
// Contacts of bodies: which can touch within a step, impacts, and which contacts stay closed afterwards, sticking or slipping.
//
// Contacts press and never pull. Within a step the instant is located at which two bodies touch, a contact would have to pull, or
// it begins to slip or to stick. There all contacts that touch take part in one impact, if they approach; then a complementarity
// problem in the accelerations tells which of them stay closed, and how.
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/contact/broad_phase.hpp>
#include <momentree/contact/candidates.hpp>
#include <momentree/contact/impact.hpp>
#include <momentree/contact/overlap_points.hpp>
#include <momentree/dynamics/contacts.hpp>
#include <momentree/dynamics/islands.hpp>
#include <momentree/simulate/contact_policy.hpp>
#include <momentree/simulate/overlap.hpp>
#include <momentree/simulate/stops.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

/// The numbers of contacts in a list, by their pair and in the order of the list.
class ContactsByPair {
 public:
  using Entry = std::pair<int, std::size_t>;  // pair, number
  ContactsByPair() = default;
  explicit ContactsByPair(std::span<const Contact> all);
  std::span<const Entry> of(int pair) const;

 private:
  std::vector<Entry> sorted_;
};

class Contacts {
 public:
  /// Instants are located to `tolerance` seconds. `step`: the length of steps (s); 0: the method adapts them.
  Contacts(World& world, Evaluator& evaluate, double tolerance, contact::Simultaneous how = contact::Simultaneous::together,
           double step = 0);
  ~Contacts();
  Contacts(const Contacts&) = delete;
  Contacts& operator=(const Contacts&) = delete;

  /// Kinetic energies (J) of the islands of closed contacts, by their numbers, without those of armatures.
  std::vector<double> kinetic_by_island() const;

  /// False if no bodies can touch: no other function of this class needs to be called then.
  bool any();
  /// To be called after bodies that can touch were added to the world or left it.
  void renew() { bodies_ = -1; }

  /// Why an instant can't be resolved.
  struct Unresolved {
    std::string why;
    bool can_be_stepped = true;  ///< time stepping continues from there
    std::vector<int> bodies{};   ///< of the island for which that is true; empty: of all that touch
  };
  /// Resolves the present instant: impacts, and which contacts are closed from now on.
  std::optional<Unresolved> resolve(std::vector<Event>& events);

  /// The joint forces, packed as p, of unit forces at points that approach each other although no impulse can change that.
  std::vector<double> rigid_pushes();

  /// What is to be located within a step of at most h seconds, which it may shorten so that nothing passes through anything.
  std::span<const Watch> watches(double& h);

  // For time stepping, which follows no closed contacts.
  /// Opens all contacts.
  void open() { set({}); }
  /// Closes contacts that were closed before.
  void close(std::vector<Contact> closed) { set(std::move(closed)); }

  // Before a run begins, and between runs where forces or the state have changed.
  /// Finds the contacts that will close without an impact, so that accelerations and forces include theirs. They are pending:
  /// the run opens them first, and closes them with their events. `method_steps`: the method steps through all contacts.
  void find_pending(bool method_steps);
  bool has_pending() const;
  /// The closed contacts, without those that are pending.
  std::vector<Contact> closed_ones() const;
  /// World::former_contacts(); an empty list leaves them as they are.
  void set_former(std::vector<Contact> closed);
  bool has_former() const { return !world_->former_contacts_.empty(); }
  void forget_former() { world_->former_contacts_.clear(); }
  /// Opens pending contacts, and closes the former ones again if the bodies still touch there and do not part.
  void open_pending();
  /// Closes contacts of a document; those that do not touch stay open.
  void close_from_document(const Forest& forest);
  /// −1 if the closed contacts fit the state and the forces. Otherwise the largest force that contacts cannot exert, relative to
  /// the largest force of its island; or the largest number, if bodies overlap or do not stay together.
  double excess_of_closed();
  /// The bodies that are stepped through, by number; none: all or no bodies are.
  void set_stepped(std::vector<bool> bodies);
  bool is_stepped(int body) const {
    return body >= 0 && static_cast<std::size_t>(body) < stepped_.size() && stepped_[static_cast<std::size_t>(body)];
  }
  /// The method steps through all contacts.
  void set_all_stepped(bool all) { all_stepped_ = all; }
  /// True if the contacts of this body are stepped through, in steps that do so for all bodies or for some.
  bool steps(int body) const { return all_stepped_ || is_stepped(body); }
  /// Joins the islands of bodies that touch at present, or whose contacts are closed.
  void join_touching(Islands& islands);
  std::vector<int> touching_bodies();
  /// The bodies of pairs that touch, one of which is stepped through and one of which is not.
  std::vector<int> touched_by_stepped();
  /// The bodies of the closed contact with the largest force.
  std::vector<int> most_loaded() const;
  /// The bodies of the contact with the slowest slip; of any closed contact if none slips.
  std::vector<int> slowest() const;
  /// What must_resolve() found about slow slip is for one instant.
  void forget_slow_slip() { slowest_ = slowest_slip; }
  int short_steps() const { return short_steps_; }
  void set_short_steps(int count) { short_steps_ = count; }
  /// A step of at most h seconds in which no body passes through another, but not much shorter: pairs that are faster are noted.
  double limit_step(double h);
  /// Bodies of pairs that were noted which did pass through each other in the step, on a straight path: where (m), on which side
  /// the first one was before, and the length of steps (s) in which they would not have done so.
  struct Passed {
    int a, b;
    Vec3 point, side;
    double step;
  };
  std::vector<Passed> passed();
  /// The fastest point of any solid (m/s).
  double fastest() const;
  /// Appends the points at which solids overlap at present, or are nearer than `within` (m), without those of bodies that stay
  /// where they are, if `stays` says so by body.
  void add_near(double within, std::vector<Contact>& out, const std::vector<bool>& stays = {}) const;
  /// Joins the islands of bodies of which solids may be nearer than `within` (m).
  void join_near(double within, Islands& islands) const;
  const ContactLaw& law_of(int pair) const { return pairs_[static_cast<std::size_t>(pair)].law; }
  /// The radius of the first solid of a pair, as a whole (m).
  double reach_of(int pair) const { return pairs_[static_cast<std::size_t>(pair)].one->solid.reach; }

  /// True after a step in which slip would have turned if it had not kept its direction: it is taken back, and repeated with
  /// less.
  bool kept_too_much() const;
  void keep_less();

  /// True after a step that ended at such an instant.
  bool must_resolve();

  /// The next instant at which a bouncing body comes to rest, or infinity.
  double next_rest() const;

  /// The pair that overlaps most at present, if any do: of contacts that are located, or of all.
  std::optional<Overlap> overlap();
  std::optional<Overlap> overlap_of_all();
  std::optional<Overlap> overlap_of_bodies();
  double deepest_of_all();  ///< its depth (m)
  /// Lets pairs that overlap after the joint between their bodies has ended pass through each other until they are apart.
  /// `before`: what joints connected. Returns the deepest one of each two bodies, with a point.
  struct Parted {
    Overlap overlap;
    Vec3 point;  // m
  };
  std::vector<Parted> let_pass(const Connections& before);
  /// Pairs that have come apart touch from now on.
  void forget_apart();
  /// The overlap of a pair of solids, or of the ends of a cable, with that depth (m).
  Overlap overlap_of(int pair, double depth) const;
  /// The pair of this body and another one that overlaps most.
  std::optional<Overlap> overlap_with(BodyId body);
  static std::optional<Overlap> overlap_of(World& world);

  /// Energy (J) that contacts took since the last call, at instants without an event, from velocities too slow to be followed.
  double take_lost() { return std::exchange(lost_, 0.0); }

 private:
  struct PairGap;
  struct Hold;
  struct Slip;
  struct Leaves;
  struct Apart;
  struct Pair {
    const Collider *one = nullptr, *other = nullptr;  ///< none of a cable
    int a = -1, b = -1;                               ///< bodies; the ground is the second one
    ContactLaw law{};
    bool while_joined = false;    ///< they also touch while a joint connects them
    double thickness = HUGE_VAL;  ///< of the thinner one; infinite with a plane
    std::string law_name{};
    int cable = -1;                          ///< its number as a spring; −1: two solids
    double size(const Contacts& all) const;  ///< of coordinates, for tolerances (m)
  };
  // Pairs of colliders by number: that of the first one times the largest number of colliders, plus that of the second one. After
  // these, cables in the order of the model's springs. Colliders that are added to the world change no numbers.
  class Pairs {
   public:
    explicit Pairs(const Model& model) : model_(&model) {}
    const Pair& operator[](std::size_t number) const;
    void clear() { known_.clear(); }

   private:
    const Model* model_;
    mutable std::unordered_map<std::size_t, Pair> known_;  // those that were near so far
  };
  struct Gap {
    double value, rate;
  };

  enum class Handling : unsigned char { located, stepped, between };
  Handling handling(const Pair& pair) const;
  void find_any();
  std::optional<Overlap> deepest(int body, bool all = false, bool cables = true);
  double depth_of(const Pair& pair, int number) const;
  const std::vector<int>& near_pairs(double h, double margin) const;
  bool are_apart(int pair) const;
  contact::Place place(int body) const;
  bool can_be_taut(std::size_t spring) const;
  contact::Features cable_features(const Pair& cable) const;
  void candidates(const Pair& pair, double within, std::vector<contact::Candidate>& out) const;
  double apart(const Pair& pair) const;
  Vec3 centre_in_other(const Pair& pair) const;
  double speed_bound(const Pair& pair) const;
  double margin_within(const Pair& pair) const;
  static double looked_within(const Pair& pair);
  double longest_step(const Pair& pair, double distance, double speed, double acceleration) const;
  double time_to_stand(const Pair& pair, double acceleration) const;
  Gap gap_of(int pair, double within) const;
  bool face_each_other(int pair) const;
  double noise_of(int pair) const;
  Vec3 slip_velocity(int contact) const { return slip_velocity(world_->tree_.contacts()[static_cast<std::size_t>(contact)]); }
  Vec3 slip_velocity(const Contact& contact) const;
  Vec3 slip_at(std::size_t i) const;
  double turning_at(std::size_t i) const;
  double turning(std::size_t contact) const;
  double turned(std::size_t contact) const;
  double kept(std::size_t contact) const;
  double most_kept(std::size_t contact) const;
  double least_kept(std::size_t contact) const;
  void keep_directions(double h);
  double slip_change_time(std::size_t contact) const;
  bool is_closed(int pair, std::uint64_t id) const;
  bool is_gone(int body) const { return body >= 0 && !world_->alive({body}); }
  std::vector<Contact> touching();
  Contact contact_of(const Pair& pair, int number, const contact::Candidate& candidate) const;
  std::vector<double> accelerations_on_others(const std::vector<Contact>& contacts, double slow);
  bool impact(const std::vector<Contact>& contacts, std::vector<Event>& events, std::string& failure);
  bool choose(const std::vector<Contact>& contacts, std::vector<Contact>& closed);
  bool choose(std::vector<Contact>& staying, std::size_t i, bool rests, std::vector<Contact>& closed);
  bool slips(const Contact& c, const Vec3& v) const;
  bool can_rest(std::vector<Contact> contacts);
  void set_law(const std::vector<Contact>& contacts);
  [[nodiscard]] bool solve_states(const std::vector<Contact>& contacts);
  double friction_of(const Contact& c) const;
  void weaken_friction();
  bool solve_weakened(double part, std::vector<double>& all);
  struct Friction {
    double force = 0, limit = 0;  // N
  };
  Friction friction_of_pair(const std::vector<Contact>& contacts, std::size_t i) const;
  bool moves_along(const std::vector<Contact>& contacts, std::size_t i) const;
  void note_ended_slip();
  void set(std::vector<Contact> contacts);
  void forget_evaluation_with_loops();
  std::span<const ContactsByPair::Entry> closed_of(int pair) const;
  struct Impulses;
  Impulses impulses_of(const std::vector<Contact>& contacts, const std::vector<double>& r) const;
  void apply(const Impulses& impulses, const std::vector<double>& r, TopologyEditor& editor, Event& event);
  struct Settled;
  std::map<int, Vec3> stop(const std::vector<Contact>& closed, Settled& settled);
  void stop_creeping(std::vector<Contact> contacts, Settled& settled);
  std::vector<std::vector<Contact>> by_island(const std::vector<Contact>& contacts) const;
  std::optional<Unresolved> strike_island(const std::vector<Contact>& touching, std::vector<Event>& events);
  std::optional<Unresolved> close_island(std::vector<Contact>& touching, const std::vector<Contact>& before,
                                         const ContactsByPair& before_by_pair, std::vector<Contact>& closed, Settled& settled);
  void report_changes(const std::vector<Contact>& before, std::size_t first, const std::map<int, Vec3>& impulses,
                      std::vector<Event>& events);
  Event begin_event(const char* what, int pair);
  void locate_event(Event& event, const std::vector<Contact>& contacts, const std::vector<double>& weights, int pair) const;
  std::string name_of(int body) const;
  std::string event_name(const char* what, int pair) const;
  double slow_approach() const;
  double usual_step() const { return step_ > 0 ? step_ : 1e-3; }  ///< also of stepping next to methods that adapt theirs (s)
  std::vector<Contact> touching_in_steps(bool method_steps);
  bool choose_pending(const std::vector<Contact>& touching, bool method_steps, std::vector<Contact>& chosen);
  std::vector<Contact> placed_again(const std::vector<Contact>& described);
  bool stay_together(const std::vector<Contact>& contacts);
  bool approach_each_other(const std::vector<Contact>& contacts);
  double excess_of_forces(std::size_t* where = nullptr);
  double excess_of_island(const std::vector<std::size_t>& island) const;

  World* world_;
  Evaluator* evaluate_;
  double tolerance_, step_;
  contact::Simultaneous simultaneous_;
  int bodies_ = -1;   // of the model when any_ was found
  bool any_ = false;  // two bodies can touch
  std::vector<bool> stepped_;
  bool all_stepped_ = false;
  Pairs pairs_;
  mutable contact::BroadPhase broad_phase_;
  mutable contact::OverlapPoints overlap_;
  mutable std::vector<contact::Ball> balls_;
  mutable std::vector<int> near_, solids_;
  mutable ContactsByPair closed_by_pair_;
  mutable std::uint64_t closed_by_pair_of_ = 0;   // the revision of the tree of which these are
  std::vector<std::pair<int, double>> settling_;  // at this instant: pairs whose bounces end later, and when
  struct Fast {
    int pair;
    Vec3 from;  // the centre of its first solid at the start of the step, in the frame of the second one's body (m)
  };
  std::vector<Fast> fast_;
  std::vector<Watch> watches_;
  std::vector<Condition> conditions_;
  std::vector<double> noise_;  // of those that are gaps, which come first
  ContactRows rows_;
  contact::System system_;
  contact::ImpactLaw law_;
  double lost_ = 0;
  std::vector<double> restitution_, after_, weaker_, much_weaker_;
  bool weakened_ = false;
  // By closed contact, of those that slip at the start of the step: speed (m/s), turning() (m/s²), and the direction.
  std::vector<double> speed_, turning_;
  std::vector<Vec3> slips_along_;
  double started_ = 0;             // when the step began (s)
  int short_steps_ = 0;            // in a row in which a contact crept
  double slowest_approach_ = 0;    // slower approaches count as rest (m/s)
  std::vector<int> jammed_;        // pairs that no finite force lets slip (Painlevé), since the last change of contacts
  double slowest_ = slowest_slip;  // slower contacts have no direction of slip when their states are next chosen (m/s)
  mutable std::vector<contact::Candidate> found_candidates_;
};

}  // namespace momentree
