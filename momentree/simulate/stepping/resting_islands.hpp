#pragma once
// Islands that rest while contacts are stepped through: they stay where they are until something comes near, and their contacts
// are neither found nor solved. What rests follows from the state and the forces of the last step alone, so that a run that
// continues another one goes on in the same way.
#include <span>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/simulate/stepping/stepping_state.hpp>

namespace momentree {

class SteppedPairs;

class RestingIslands {
 public:
  /// To be called before a step, with an evaluation of the state: notes which bodies stand still under nothing but their weight
  /// and these forces, those of the last step. Rates are those of a step of the usual length (s).
  void begin_step(const Tree& tree, const State& state, Workspace<double>& workspace, std::span<const SteppedContact> points,
                  double usual_step);

  /// At the end of a step without contacts: puts islands of these bodies back to where they were, if nothing else may be nearer
  /// than `within` (m). True if there are any: the state then needs an evaluation.
  bool put_back(const Tree& tree, State& state, const SteppedPairs& pairs, double within, std::span<const SteppedContact> points);
  /// By body: it was put back. Empty: none was.
  const std::vector<bool>& stays() const { return stays_; }
  bool stays(int body) const { return body >= 0 && !stays_.empty() && stays_[static_cast<std::size_t>(body)]; }

  /// At the end of a step: mechanisms that hardly moved before and after it, and that something carries, stand still.
  void come_to_rest(const Tree& tree, State& state, std::span<const SteppedContact> points);

 private:
  void find_loose(const Tree& tree);

  std::vector<double> q_, u_;                // at the start of the step
  std::vector<bool> loose_, rests_, stays_;  // by body: only its weight and contacts act on it; it rested at the start; it stays
};

}  // namespace momentree
