#pragma once
// Steps of adaptive methods near singular positions of loops, which a mechanism passes smoothly. The rates of a stage are right
// there only where the loops are closed: elsewhere they have a pole, and at a clearance d they are known to round-off / d³. A
// step whose stages would come near such a position is therefore repeated with stages that are closed before they are evaluated,
// and its length is chosen such that the position lies in the widest gap between the stages. What then still opens the loops in
// the estimated error is left out, because closing them at the end of the step removes it.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/integrate/integrator.hpp>

namespace momentree {

/// Where the next singular position is, or the last one, as seen from the start of a step: by the loops' clearance, which near it
/// is proportional to the distance.
class SingularPosition {
 public:
  /// A step begins at the state that was evaluated last.
  void begin(const Evaluator& evaluate) noexcept {
    if (!evaluate.tree().has_loops() || !evaluate.tree().contacts().empty() || evaluate.variables() == Variables::momenta) return;
    start_ = least_ = loop_clearance(evaluate.workspace());
    rank_ = evaluate.workspace().loops->rank;
  }
  /// False for a tree without loops, with contacts, and for states in momenta, whose rates closed stages would change.
  bool possible() const noexcept { return start_ < HUGE_VAL; }

  /// Notes a stage. True if it is the first one of a step of length h, at its fraction c, and a singular position is in sight.
  bool note(const Workspace<double>& workspace, bool first, double c, double h) noexcept {
    const double now = loop_clearance(workspace);
    least_ = std::min(least_, now);
    if (!first) return false;
    rate_ = std::fabs(start_ - now) / (c * h);
    return in_sight_ = start_ < wide && rate_ * sight() * h > start_;
  }
  /// Whether it is worth locating for a step of length h that failed. Generated code does not tell clearances of stages.
  bool likely(double h) const noexcept { return in_sight_ || (rate_ > 0 ? 2 * rate_ * sight() * h > start_ : start_ < wide); }
  /// At the end of a step: whether a stage or the end came close to a singular position.
  bool met(const Workspace<double>& workspace) const noexcept {
    if (!possible()) return false;
    const double now = loop_clearance(workspace);
    return workspace.loops->rank < rank_ || std::min(least_, now) < 0.1 * (start_ + now);
  }

  /// Finds the position from the clearances at the start and shortly after. True if steps of length h (s) come near it.
  bool locate(double start, double then, double after, double h) noexcept {
    from_ = start;
    at_ = after * start / (start - then);
    return in_sight_ || std::fabs(at_) < sight() * h;
  }
  /// The same from the clearance at the end of a step of length h; false if that was done twice.
  bool correct(double end, double h) noexcept {
    if (++corrections_ > 2) return false;
    const bool across = at_ > 0 && at_ < h;
    if (across || end < from_) at_ = h * from_ / (across ? from_ + end : from_ - end);
    return true;
  }
  /// The step to take where one of length h is possible, for a method whose widest gap has its middle at that fraction of a step.
  double step(double h, double gap) const noexcept {
    constexpr double growth = 10, reserve = 0.9;
    if (!(at_ > 0)) return std::min(h, -growth * at_);
    if (at_ > (1 + gap) * h) return h;
    return at_ <= gap * h ? at_ / gap : std::min(h, std::max(at_ / 2, at_ - reserve * gap * h));
  }

 private:
  static constexpr double close = 0.1, wide = 0.4;  // clearances
  // How many steps away the position is when it is taken into account. Mechanisms with light parts have a small clearance always.
  double sight() const noexcept { return start_ < close ? 10 : start_ < wide ? 2 : 1.2; }

  double start_ = HUGE_VAL, least_ = HUGE_VAL;  // clearance at the start, and the least one of the stages
  double rate_ = 0;                             // between the start and the first stage (1/s), without its sign
  double from_ = 0, at_ = 0;                    // clearance at the start by the rows of `locate`, and the position's distance (s)
  int rank_ = 0, corrections_ = 0;
  bool in_sight_ = false;
};

}  // namespace momentree
