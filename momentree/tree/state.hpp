#pragma once
// What moves: time, coordinates, canonical momenta, packed in the order of body numbers.
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/base/numbers.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Identifies what a computation was made from: one state, between two changes of it, on one topology of one tree. No two states
/// of a process ever have the same stamp, whenever and wherever they live; a default stamp is that of no state.
struct Stamp {
  std::uint64_t state = 0, serial = 0, topology = 0;
  friend bool operator==(const Stamp&, const Stamp&) = default;
};

class State {
 public:
  State();
  /// The joints' zero, at rest, at time 0. Capacity for every later topology is reserved. The start values of a model:
  /// `start_state` (dynamics/momentum.hpp).
  explicit State(const Tree& tree);
  /// A copy is a state of its own: what was evaluated on the original is not taken for the copy's. A moved state keeps its stamp.
  State(const State& other);
  State(State&& other) noexcept;
  State& operator=(const State& other);
  State& operator=(State&& other) noexcept;
  ~State() = default;

  double time() const { return time_; }
  Numbers q() const { return q_; }
  Numbers p() const { return p_; }
  /// Tree::revision() of the tree that it is a state of.
  std::uint64_t topology() const { return topology_; }
  /// While the state is being edited it is another one each time: nobody knows what is written in between.
  Stamp stamp() const {
    if (edits_ != 0) ++serial_;
    return {number_, serial_, topology_};
  }
  /// True while an Edit of it is alive: it is evaluated anew each time then, and can't be changed, assigned to or moved
  /// otherwise.
  bool being_edited() const { return edits_ != 0; }

  class Edit;
  /// To change the state: `state.edit().p[0] = 1`, or for several changes
  ///
  ///     {
  ///       const State::Edit edit = state.edit();
  ///       edit.time = 0, edit.q[0] = 0.1, edit.p[0] = 1;
  ///     }  // the edit ends here
  ///
  /// What was evaluated on the state before is stale, and so is, once the edit ends, what was evaluated while it lived.
  [[nodiscard]] Edit edit();

  /// Makes room for another topology of the tree: replaces `nq`, `nv` numbers of a body by new ones. Does not allocate unless
  /// bodies were added to the tree that the state was made for.
  void replace(int first_q, int nq, std::span<const double> q, int first_p, int nv, std::span<const double> p, const Tree& tree);
  /// Becomes another state altogether, of that tree. Does not allocate where the reserve, that of the tree, is enough.
  void assign(double time, std::span<const double> q, std::span<const double> p, const Tree& tree);

 private:
  void changed() { ++serial_; }
  void require_no_edit() const;

  double time_ = 0;
  std::vector<double> q_, p_;
  std::uint64_t number_, topology_ = 0;
  mutable std::uint64_t serial_ = 0;
  int edits_ = 0;
};

/// Write access to a state for as long as it lives. Keep no pointer, reference or iterator into the state beyond that.
class [[nodiscard]] State::Edit {
  State& state_;

 public:
  /// They can't be copied out of the Edit, so that nothing is written after its end.
  class Writable {
   public:
    double& operator[](std::size_t i) const {
      MT_REQUIRE(i < all_.size(), "an index below size()");
      return all_[i];
    }
    std::size_t size() const { return all_.size(); }
    // Only of an Edit that has a name: the one of `state.edit().q.data()` has ended before anything is written.
    double* data() const& { return all_.data(); }
    auto begin() const& { return all_.begin(); }
    auto end() const& { return all_.end(); }
    double* data() const&& = delete;
    void begin() const&& = delete;
    void end() const&& = delete;
    Writable(const Writable&) = delete;
    Writable& operator=(const Writable&) = delete;
    ~Writable() = default;

   private:
    friend class State::Edit;
    explicit Writable(std::span<double> all) : all_(all) {}
    std::span<double> all_;
  };

  double& time;
  Writable q, p;

  explicit Edit(State& state) : state_(state), time(state.time_), q(state.q_), p(state.p_) {
    ++state_.edits_;
    state_.changed();
  }
  ~Edit() {
    state_.changed();  // whatever was computed while it lived
    --state_.edits_;
  }
  Edit(const Edit&) = delete;
  Edit& operator=(const Edit&) = delete;
};

inline State::Edit State::edit() { return Edit(*this); }

}  // namespace momentree
