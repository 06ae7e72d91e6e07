#pragma once
// Impulses at many contact points at once, without the dense matrix of all of them. The law is that of System and ImpactLaw; a
// few projected Gauss–Seidel sweeps and Newton's method solve it, to the accuracy of a time step where bodies move. Whatever they
// reach, momentum is exact and the kinetic energy does not grow.
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <momentree/contact/law_newton.hpp>
#include <momentree/contact/shapes/links.hpp>

namespace momentree::contact {

/// Points at which impulses act, and what these move: each point acts on the degrees of freedom of two mechanisms only, or on two
/// bodies of large trees, along which what impulses do is carried from point to point.
class MovedPoints {
 public:
  /// The degrees of freedom of one mechanism on which a point acts, or the six of one of its bodies.
  struct Part {
    int group = -1;            ///< number of the mechanism; −1: none, such as the ground
    int first = 0, count = 0;  ///< its numbers in a LinksMotion
    std::size_t at = 0;        ///< where its three rows of `count` numbers begin in J and in Y
    int link = -1;             ///< the body's, in `links`; −1: the rows are those of the whole mechanism
  };
  struct Point {
    std::array<Part, 2> parts{};
    double friction = 0, restitution = 0;
    double carried = 0;  ///< with restitution: the speed that weight gives in a step, of which nothing is returned (m/s)
    double slack = 0;    ///< the speed with which it may approach afterwards, because a gap is left (m/s)
    /// The point before this one whose normal impulse limits the moments of this one: about the normal, at most `torsion` times
    /// that, and about both tangents, `friction` times that (C7). −1: a point of contact.
    int pressed_by = -1;
    double torsion = 0;
  };

  /// Forgets all points. How many degrees of freedom there are, without those of mechanisms that have links; mechanisms; links.
  void clear(int dofs, int groups, int bodies);

  std::vector<Point> points;
  Links links;
  std::vector<double> J;  ///< the rows of each point, along its normal and two tangents
  std::vector<double> Y;  ///< M⁻¹ Jᵀ, by row

  /// Nothing moves.
  void start(LinksMotion& motion) const { links.start(motion, dofs_); }
  /// What a point acts on does not move any more.
  void forget(std::size_t point, LinksMotion& motion) const;
  /// The part of a motion along a row of a point, or along its normal; along all three.
  double along(std::size_t point, std::size_t row, LinksMotion& motion);
  double along_normal(std::size_t point, LinksMotion& motion) { return along(point, 0, motion); }
  void all_along(std::size_t point, LinksMotion& motion, double* w);
  /// Adds what an impulse at a point moves.
  void add(std::size_t point, const double* impulse, LinksMotion& motion);
  /// What a unit impulse along each row of a point does along each of them.
  std::array<double, 9> block(std::size_t point);
  /// How each of these links of a tree moves by wrenches on each of them: the motion of links[j] by unit wrenches on links[i] is
  /// in six columns.
  void find_responses(const std::vector<int>& touched, std::vector<double>& responses);

 private:
  LinksMotion& unmoved();

  int dofs_ = 0;
  LinksMotion trial_;  // nothing moves between calls
};

/// The impulses at the points of an island as a problem of LawNewton. What moves together is a mechanism, or all links of a large
/// tree that have points.
class IslandNewton {
 public:
  /// The points of an island that anything can press: with the velocities `start` without impulses, and the least normal
  /// impulses; without these, with gaps and normal directions alone. False if a tree has so many links with points that its dense
  /// matrix would take long.
  /// `A`: of each point, what it does to itself. `tangential`: the larger eigenvalue of the tangential part.
  bool begin(MovedPoints& of, std::span<const std::size_t> island, const std::vector<std::array<double, 9>>& A,
             const std::vector<double>& tangential, const std::vector<double>& start, const std::vector<double>* least);
  /// Improves the impulses, with so many rows of each point; see LawNewton::solve().
  double solve(std::vector<double>& impulses, std::size_t rows, double accuracy, double enough);

 private:
  std::vector<std::size_t> pressing_;  // the points that anything can press
  LawNewton newton_;
  std::vector<int> block_of_, place_of_;        // in newton_: by group, its block; by link, where its motion begins there
  std::vector<int> sizes_;                      // of the blocks there
  std::vector<std::vector<int>> touched_;       // by block: the links that have points
  std::vector<std::vector<double>> responses_;  // by block: MovedPoints::find_responses()
  std::vector<double> wide_, exact_;
};

class ManyPoints : public MovedPoints {
 public:
  /// As MovedPoints::clear().
  void clear(int dofs, int groups, int bodies = 0);

  std::vector<double> b;  ///< velocities before, three of each point
  std::vector<double> r;  ///< impulses; on entry of solve() a guess

  static constexpr double in_motion = 1e-4;  ///< a residual that steps may leave
  static constexpr double at_rest = 2e-11;   ///< with it, what rests moves by less than 1e-9 m in 10 s
  /// Finds the impulses of an impact, islands one by one, with a residual of at most `accuracy`. It is less where the guess was
  /// good: the square of that one's, down to `at_rest`; and where there was none.
  void solve(double accuracy = in_motion);
  /// The largest violation of the law that solve() left, as a velocity relative to the largest one of the island before.
  double residual() const { return residual_; }
  /// M⁻¹ Jᵀ r, the change of all velocities.
  LinksMotion& change() { return change_; }
  /// Velocities after the impact, three of each point.
  void velocities(std::vector<double>& w);
  /// M⁻¹ Jᵀ of the impulses times a factor for each point. Valid until the next call of this or of separate().
  LinksMotion& displacement(const std::vector<double>& factors);

  /// The smallest motion that removes negative gaps (m, one of each point), by displacements along the normals, to `accuracy`
  /// times the deepest gap. `pushes`: its multipliers (kg m, rad in generalised terms), one of each point; returns the
  /// displacement of all degrees of freedom.
  LinksMotion& separate(const std::vector<double>& gaps, std::vector<double>& pushes, double accuracy = 1e-3);

 private:
  using Island = std::span<const std::size_t>;
  void prepare();
  int root(int group);
  Island island(std::size_t number) const;
  double relax(std::size_t point, const std::vector<double>& start, std::vector<double>& impulses);
  double relax_moments(std::size_t point, const std::vector<double>& start, double N, double* own);
  double find_impulses(Island island, const std::vector<double>& start, std::vector<double>& impulses);
  double energy_change(Island island, const std::vector<double>& start, const std::vector<double>& impulses);
  double lose_energy(Island island, const std::vector<double>& start, std::vector<double>& impulses);
  void restart(Island island, const std::vector<double>& impulses);
  void return_no_weight(Island island);
  void expand(Island island);

  std::vector<int> parent_;                               // of groups, for the islands
  std::vector<std::size_t> order_, ends_;                 // points island by island, and where each island ends
  std::vector<std::array<double, 9>> blocks_, inverses_;  // A of each point, and its inverse
  std::vector<double> tangential_;                        // the larger eigenvalue of its tangential part
  LinksMotion change_, moved_;
  IslandNewton newton_;
  double accuracy_ = in_motion, residual_ = 0;
  std::vector<double> least_, returns_, after_, rebound_, best_;
};

}  // namespace momentree::contact
