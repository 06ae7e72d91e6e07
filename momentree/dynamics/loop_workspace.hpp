#pragma once
// Memory of the loops' rows, part of a Workspace.
#include <vector>

#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

/// A loop at present: its frames in the world and the motion of the child side.
struct LoopPlace {
  Mat3 Ra;      ///< axes of the parent-side frame in the world
  Vec3 xa, xb;  ///< origins of the two frames
  Mat3 R;       ///< pose of the child-side frame in the parent-side frame
  Vec3 r;
  Vec3 va, wa;      ///< velocity of the point at xa and angular velocity of the parent, world axes
  Vec3 vb, wb;      ///< the same of xb and the child
  double size = 0;  ///< for tolerances: distance of the loop's bodies from the world's origin, and their extent (m)
};

/// One row in the world: φ̇ = F·(v of x_b less that of the parent there) + T·(relative angular velocity); of a coupling
/// φ̇ = u(joint) − slope·u(follows), and F and T are zero.
struct LoopRow {
  Vec3 F, T;
  double slope = 0;     ///< f′ of a coupling
  double residual = 0;  ///< φ
  double velocity = 0;  ///< J u
  double drift = 0;     ///< J̇ u
  double scale = 1;     ///< bound of the row's element of A
};

/// One row at one stop: the unit wrench K on the body, first articulated, then reduced; k = Eᵀ K + effort and y = Mj⁻¹ k.
struct LoopColumn {
  Force<double> K;
  double effort = 0;  ///< of a coupling's row on the joint of the body
  double k[6], y[6];
};

struct LoopWorkspace {
  std::uint64_t topology = 0;       ///< Tree::revision() for which everything is laid out and rows were chosen; 0: none
  std::vector<LoopPlace> places;    ///< by loop
  std::vector<double> turns;        ///< by loop: the angle to which its own is nearest
  std::vector<LoopRow> rows;        ///< by row
  std::vector<LoopColumn> columns;  ///< by stop and row
  std::vector<int> chosen;          ///< the chosen rows; all of them while rows are being chosen
  std::vector<int> position;        ///< by row: its place among the chosen ones, −1 if it is not
  std::vector<double> A, factor;    ///< of all rows, row-major; Cholesky factor of the chosen ones
  std::vector<double> b, lambda;    ///< by row
  std::vector<int> order;           ///< scratch of the pivoted factorisation
  int rank = 0;
  bool impulsive = false;                              ///< the multipliers are impulses
  bool least = false;                                  ///< the multipliers are those of the least reactions
  std::vector<double> sizes;                           ///< by coupling that acts: of its equation, for tolerances (rad or m)
  std::vector<unsigned char> open_bodies, open_loops;  ///< by body and by link: 1 if the loops leave the joint's reaction open
};

}  // namespace momentree
