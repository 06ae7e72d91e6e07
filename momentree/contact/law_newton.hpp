#pragma once
// The law of contact (C2) at the points of an island, by Newton's method on its projections (C3) (Alart & Curnier 1991).
//
// Points that carry a load together make the linearised law (C4) singular, so each of them yields a little about the last
// solution, less and less (C5). Where Newton's method fails, it starts again from the minimum of a convex function (C6).
// Equations are those of docs/theory.md.
#include <array>
#include <cstddef>
#include <vector>

#include <momentree/contact/block_elimination.hpp>

namespace momentree::contact {

/// The law, linearised at the points of an island: Δr = c − K Δw, which leaves a sparse system for the motion (C4).
class LawMatrix {
 public:
  /// The rows of a point in the motion of a mechanism.
  struct Part {
    int block = -1;             ///< of the mechanism; −1: none
    int first = 0, count = 0;   ///< J acts on these components of its motion
    const double* J = nullptr;  ///< three rows of `count`
    const double* Y = nullptr;  ///< three rows of the size of the block
  };
  struct Point {
    std::array<Part, 2> parts{};
    double friction = 0, least = 0;  ///< see PointLaw, as the next two
    int pressed_by = -1;             ///< the point before this one whose normal impulse limits the moments (C7); −1: a contact
    double torsion = 0;              ///< of moments: of the first row; `friction` is that of the other two
    bool slipping = false;
    std::array<double, 2> direction{};
    std::array<double, 3> b{};  ///< velocities without impulses, along the rows
  };

  /// Begins with a problem without points. `sizes`: of the motion of each mechanism.
  void clear(const std::vector<int>& sizes);
  std::vector<Point> points;
  /// To be called once all points are known.
  void prepare();
  std::vector<std::array<double, 9>> A;  ///< of each point: its own mobility
  std::vector<double> tangential;        ///< the larger eigenvalue of its tangential part

  /// (C1): w = b + J Σ Y r.
  void find_velocities(const double* r, std::vector<double>& w);
  /// Adds J Σ Y r to w.
  void add_change(const double* r, double* w);

  std::vector<double> c;                 ///< the linearised law, of each point
  std::vector<std::array<double, 9>> K;  ///< the same
  std::vector<std::array<double, 9>> G;  ///< of moments, K by the velocity of the point that presses; in its first column
  /// (C4): Δr. False if the system is singular.
  bool solve(std::vector<double>& step);

 private:
  std::size_t size_of(const Part& part) const { return static_cast<std::size_t>(sizes_[static_cast<std::size_t>(part.block)]); }
  void add_motion(const Point& point, const double* r);
  void add_velocity(const Point& point, double* w) const;
  void add_matrix(const Point& point, const Point& by, const std::array<double, 9>& factors);

  std::vector<int> sizes_;
  std::vector<double> x_, KJ_;
  BlockElimination matrix_;
};

class LawNewton {
 public:
  /// Of velocities, relative to what the impulse of a point does to it alone.
  static constexpr double round_off = 2e-15;

  using Part = LawMatrix::Part;
  using Point = LawMatrix::Point;

  /// Begins with a problem without points. `sizes`: of the motion of each mechanism.
  void clear(const std::vector<int>& sizes) { law_.clear(sizes), prepared_ = false; }
  void add(const Point& point) { law_.points.push_back(point); }

  /// Improves the impulses r, three of each point, until their residual is at most `accuracy`; where that is hard to reach, at
  /// most `enough`. Leaves the best ones that it found in r and returns their residual: the largest violation of the law, as a
  /// velocity relative to the largest one of the problem.
  double solve(double* r, double accuracy, double enough);
  /// The same to round-off, with steps that are shortened from the start: for few points that are solved once.
  double solve_carefully(double* r, double accuracy);
  /// The residual at r.
  double residual(const double* r);

 private:
  void prepare();
  double natural_map(const double* r, bool linearise);
  double violation(const double* r) const;
  double take_whole_steps(double accuracy, double enough);
  double take_shorter_steps(double best, double accuracy);
  void take_best(double* r);
  bool newton();
  void find_nearest(std::size_t point, const double* w, double* r, bool linearise);
  double slope(double length);
  double find_length();
  double minimise();

  LawMatrix law_;
  bool prepared_ = false;
  double scale_ = 0, yield_ = 0, accuracy_ = 0;
  std::vector<double> normal_;  // the normal impulse to which friction is bound
  std::vector<double> w_, r_, centre_, from_, step_, best_, shift_, minimum_, moved_;
};

}  // namespace momentree::contact
