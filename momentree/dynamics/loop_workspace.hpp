#pragma once
// Memory of the loops' rows, part of a Workspace.
#include <vector>

#include <momentree/dynamics/loops.hpp>
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

/// One row in the world: φ̇ = F·(v of x_b less that of the parent there) + T·(relative angular velocity).
struct LoopRow {
  Vec3 F, T;
  double residual = 0;  ///< φ
  double velocity = 0;  ///< J u
  double drift = 0;     ///< J̇ u
  Vec3 rate;            ///< dT/dt, of an inertial observer
  double scale = 1;     ///< bound of the row's element of A
};

/// One row at one stop: the unit wrench K on the body, first articulated, then reduced; k = Eᵀ K and y = Mj⁻¹ k.
struct LoopColumn {
  Force<double> K;
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
  LoopRows wanted{};                ///< of the evaluation in momenta that is going on
  std::vector<double> gauge;        ///< by row: impulses that the last closing in momenta added to the momenta
  std::vector<double> u;            ///< velocities, scratch of that closing
  std::vector<Force<double>> momenta, wrenches;  ///< by body, scratch of rates of momenta
  int rank = 0;
  bool impulsive = false;                              ///< the multipliers are impulses
  bool least = false;                                  ///< the multipliers are those of the least reactions
  std::vector<unsigned char> open_bodies, open_loops;  ///< by body and by loop: 1 if the loops leave the joint's reaction open
};

}  // namespace momentree
