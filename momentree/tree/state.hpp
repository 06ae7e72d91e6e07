#pragma once
// The state of motion: time, coordinates, and canonical momenta or velocities, packed in the order of joint numbers.
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/base/numbers.hpp>
#include <momentree/joint/turns.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Identifies the input of a computation: one state, between two changes of it, on one topology of one tree. No two states of a
/// process ever have the same stamp, whenever and wherever they live; a default stamp belongs to no state.
struct Stamp {
  std::uint64_t state = 0, serial = 0, topology = 0;
  friend bool operator==(const Stamp&, const Stamp&) = default;
};

/// What a state holds beside the coordinates. Momenta are exact where the topology changes; velocities are the better conditioned
/// choice between changes, above all in long chains. See docs/theory.md.
enum class Variables : unsigned char {
  momenta,    ///< canonical momenta p; the rate of a prescribed motion in the place of a driven DoF
  velocities  ///< joint velocities u
};

class State {
 public:
  State();
  /// All joints at zero and at rest, at time 0. Reserves capacity for every later topology. For the start values of a model see
  /// `start_state` (dynamics/momentum.hpp).
  explicit State(const Tree& tree, Variables variables = Variables::momenta);
  /// A copy is a separate state: evaluations of the original are not valid for it. A moved state keeps its stamp.
  State(const State& other);
  State(State&& other) noexcept;
  State& operator=(const State& other);
  State& operator=(State&& other) noexcept;
  ~State() = default;

  double time() const { return time_; }
  Numbers q() const { return q_; }
  Variables variables() const { return variables_; }
  /// The momenta of a state in momenta.
  Numbers p() const {
    MT_REQUIRE(variables_ == Variables::momenta, "a state in momenta: World::p() gives the momenta of any world");
    return y_;
  }
  /// The velocities of a state in velocities.
  Numbers u() const {
    MT_REQUIRE(variables_ == Variables::velocities, "a state in velocities: World::v() gives the velocities of any world");
    return y_;
  }
  /// p or u, for code that treats both alike.
  Numbers y() const { return y_; }
  /// By loop: the angles of its joint when it was last closed, which tell full turns apart. Empty: all zero.
  const std::vector<Turns>& turns() const { return turns_; }
  void set_turns(std::span<const Turns> turns);
  /// Of one loop, by its place in Tree::loops(): sets its angles, or removes them with the loop.
  void set_turns(std::size_t place, const Turns& turns);
  void remove_turns(std::size_t place);
  /// Tree::revision() of the tree to which the state belongs.
  std::uint64_t topology() const { return topology_; }
  /// While the state is being edited each call returns a new stamp, because anything may have been written in between.
  Stamp stamp() const {
    if (edits_ != 0) ++serial_;
    return {number_, serial_, topology_};
  }
  /// True while an Edit of the state is alive: it is then evaluated anew each time, and must not be changed, assigned to or moved
  /// otherwise.
  bool being_edited() const { return edits_ != 0; }

  class Edit;
  /// Write access: `state.edit().p[0] = 1`, or for several changes
  ///
  ///     {
  ///       const State::Edit edit = state.edit();
  ///       edit.time = 0, edit.q[0] = 0.1, edit.p[0] = 1;
  ///     }  // the edit ends here
  ///
  /// Earlier evaluations of the state become stale, and when the edit ends, so do those made during it.
  [[nodiscard]] Edit edit();

  /// Adapts the state to another topology of the tree: replaces `nq` and `nv` numbers of a body by new ones, of q and y. Does not
  /// allocate unless bodies were added to the tree for which the state was made.
  void replace(int first_q, int nq, std::span<const double> q, int first_p, int nv, std::span<const double> y, const Tree& tree);
  /// Sets the whole state, of that tree, in its present variables. Does not allocate if the reserved capacity, that of the tree,
  /// suffices.
  void assign(double time, std::span<const double> q, std::span<const double> y, const Tree& tree);
  /// From now on y are velocities u, or momenta p, with these values.
  void change_variables(Variables variables, std::span<const double> y);

 private:
  void changed() { ++serial_; }
  void require_no_edit() const;

  double time_ = 0;
  std::vector<double> q_, y_;
  std::vector<Turns> turns_;
  Variables variables_ = Variables::momenta;
  std::uint64_t number_, topology_ = 0;
  mutable std::uint64_t serial_ = 0;
  int edits_ = 0;
};

/// Write access to a state during the Edit's lifetime. Keep no pointer, reference or iterator into the state beyond it.
class [[nodiscard]] State::Edit {
  State& state_;

 public:
  /// Cannot be copied out of the Edit, so that nothing is written after its end.
  class Writable {
   public:
    double& operator[](std::size_t i) const {
      MT_REQUIRE(i < all_.size(), "an index below size()");
      return all_[i];
    }
    std::size_t size() const { return all_.size(); }
    // Only of a named Edit: the temporary in `state.edit().q.data()` ends before anything is written.
    double* data() const& { return all_.data(); }
    auto begin() const& { return all_.begin(); }
    auto end() const& { return all_.end(); }
    double* data() const&& = delete;
    void begin() const&& = delete;
    void end() const&& = delete;
    Writable(const Writable&) = delete;
    Writable& operator=(const Writable&) = delete;
    ~Writable() = default;
    explicit Writable(std::span<double> all) : all_(all) {}

   private:
    std::span<double> all_;
  };

  double& time;
  Writable q;
  Writable y;     ///< p or u
  Writable p, u;  ///< the one that the state does not hold is empty

  explicit Edit(State& state)
      : state_(state),
        time(state.time_),
        q(state.q_),
        y(state.y_),
        p(state.variables_ == Variables::momenta ? std::span<double>(state.y_) : std::span<double>()),
        u(state.variables_ == Variables::velocities ? std::span<double>(state.y_) : std::span<double>()) {
    ++state_.edits_;
    state_.changed();
  }
  ~Edit() {
    state_.changed();  // evaluations made during the edit are stale
    --state_.edits_;
  }
  Edit(const Edit&) = delete;
  Edit& operator=(const Edit&) = delete;
};

inline State::Edit State::edit() { return Edit(*this); }

}  // namespace momentree
