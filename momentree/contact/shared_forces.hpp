#pragma once
// Forces of redundant contacts. Where the equations of closed contacts, Q x = b with orthonormal rows, leave forces open, as
// under the four corners of a box or at a contact of a body that joints guide, all their solutions move the bodies alike. Of
// those that contacts can exert, within K: N ≥ 0 and |t| ≤ μ N of each, the least one is taken:
//
//   min ½|x|²  with Q x = b, x ∈ K:  x = P(Qᵀ λ), where λ is the least of ½|P(Qᵀ λ)|² − bᵀλ               (S1)
//
// and P projects on K. How far inside of K forces can be is their margin, the largest s with x − s e ∈ K, where e has N = 1 for
// each contact; δ makes it smooth and decreases to nearly zero:
//
//   max s − ½ δ |x − s e|²:  x − s e = P(−Qᵀ λ)/δ, where λ is the least of bᵀλ + |P(−Qᵀ λ)|²/(2δ) with (Q e)ᵀλ = 1   (S2)
//
// Both are solved by Newton's method for the few unknowns λ.
#include <cstddef>
#include <span>
#include <vector>

namespace momentree::contact {

/// What one contact can exert, by the numbers of its unknowns: N at `normal`, and t at the following two if it has friction.
struct ForceCone {
  std::size_t normal = 0;
  double friction = 0;  ///< μ; 0: none, and no unknowns for t
  /// The largest s with x in the cone moved by s along N.
  double margin(const std::vector<double>& x) const;
};

class SharedForces {
 public:
  /// `x`: forces that obey the equations, with `rows` Q, one after the other. Replaces x by the least forces that contacts can
  /// exert. False if there are none: x is then the solution of (S2).
  bool choose(std::vector<double>& x, const std::vector<double>& rows, std::span<const ForceCone> cones);
  /// The margin of the forces that choose() was given last, relative to the largest of these and at most 1.
  double margin();

 private:
  void set(const std::vector<double>& x, const std::vector<double>& rows, std::span<const ForceCone> cones);
  double project(double sign);
  void add_curvature(double factor);
  double find_gradient(double factor);
  bool minimise(double sign, double curvature);
  double deepest(double smallest);

  std::vector<double> Q_, b_, e_, Qe_;
  std::vector<ForceCone> cones_;
  std::size_t unknowns_ = 0;
  double size_ = 0;          // of the forces given; all are relative to it
  double known_margin_ = 0;  // of the forces chosen by (S2)
  bool possible_ = false;
  std::vector<double> lambda_, from_, x_, point_, gradient_, H_, factor_, step_, along_;
};

}  // namespace momentree::contact
