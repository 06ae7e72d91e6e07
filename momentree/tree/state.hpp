#pragma once
// What moves: time, coordinates, canonical momenta, packed in the order of body numbers.
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// Says of which state and topology something was computed. Work carries it; what reads Work requires it to be of this state.
struct Stamp {
  const void* state = nullptr;
  std::uint64_t serial = 0, topology = 0;
  friend bool operator==(const Stamp&, const Stamp&) = default;
};

class State {
 public:
  State() = default;
  /// The joints' zero, at rest, at time 0. Capacity for every later topology is reserved. The start values of a model:
  /// `start_state` (dynamics/momentum.hpp).
  explicit State(const Tree& tree);
  State(const State& other) { *this = other; }
  State& operator=(const State& other);

  double time() const { return time_; }
  std::span<const double> q() const { return q_; }
  std::span<const double> p() const { return p_; }
  std::uint64_t topology() const { return topology_; }
  Stamp stamp() const { return {this, serial_, topology_}; }

  /// To change the state: makes every Work that was evaluated on it stale.
  struct Edit {
    double& time;
    std::span<double> q, p;
  };
  Edit edit() {
    ++serial_;
    return {time_, q_, p_};
  }
  /// Makes room for another topology: replaces `nq`, `nv` numbers of a body by new ones. Does not allocate unless bodies were
  /// added to the tree that the state was made for.
  void replace(int first_q, int nq, std::span<const double> q, int first_p, int nv, std::span<const double> p,
               std::uint64_t topology);
  /// Becomes another state altogether, of that topology. Does not allocate where the reserve, that of the tree, is enough.
  void assign(double time, std::span<const double> q, std::span<const double> p, std::uint64_t topology);

 private:
  double time_ = 0;
  std::vector<double> q_, p_;
  std::uint64_t serial_ = 0, topology_ = 0;
};

}  // namespace momentree
