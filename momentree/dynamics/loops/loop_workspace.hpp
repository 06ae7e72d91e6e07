#pragma once
// Memory of the loops' rows, part of a Workspace.
#include <algorithm>
#include <vector>

#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/math/signal.hpp>

namespace momentree {

/// A loop at present: its frames in the world and the motion of the child side.
template <class T>
struct LoopPlaceOf {
  Matrix3<T> Ra;      ///< axes of the parent-side frame in the world
  Vector3<T> xa, xb;  ///< origins of the two frames
  Matrix3<T> R;       ///< pose of the child-side frame in the parent-side frame
  Vector3<T> r;
  Vector3<T> va, wa;  ///< velocity of the point at xa and angular velocity of the parent, world axes
  Vector3<T> vb, wb;  ///< the same of xb and the child
  T size{};           ///< for tolerances: distance of the loop's bodies from the world's origin, and their extent (m)
};
using LoopPlace = LoopPlaceOf<double>;

/// One row in the world: φ̇ = F·(v of x_b less that of the parent there) + T·(relative angular velocity); of a coupling
/// φ̇ = u(joint) − slope·u(follows), and F and T are zero.
template <class S>
struct LoopRowOf {
  Vector3<S> F, T;
  S slope{};        ///< f′ of a coupling
  S residual{};     ///< φ
  S velocity{};     ///< J u
  S drift{};        ///< J̇ u
  Vector3<S> rate;  ///< dT/dt, of an inertial observer; of rows of single DoFs see loop_dof_rate
  S scale = S(1);   ///< bound of the row's element of A
  S softness{};     ///< the inverse of an armature, added to the row's element of A
  S jump_to{};      ///< J u after an impact, less what `velocity` leaves out
};
using LoopRow = LoopRowOf<double>;

/// The velocity of a loop joint's DoF before a change.
struct ArmatureSpeed {
  int loop, dof;  ///< the loop by its number
  double speed;
};

/// One row at one stop: the unit wrench K on the body, first articulated, then reduced; k = Eᵀ K + effort and y = Mj⁻¹ k.
template <class T>
struct LoopColumnOf {
  Force<T> K;
  T effort{};  ///< of a coupling's row on the joint of the body
  T k[6], y[6];
};
using LoopColumn = LoopColumnOf<double>;

/// Rows of the system A, in the order of the loops, and where its elements are stored. Two loops without a common stop have none:
/// of each row the elements from that of the first loop with which its own is coupled up to the diagonal are kept.
struct LoopLayout {
  std::vector<int> rows;                 ///< their numbers, ascending
  std::vector<int> first_of;             ///< by loop, and one more: its first row here
  std::vector<int> begin;                ///< by row here: the first one whose element is stored
  std::vector<std::ptrdiff_t> position;  ///< by row here: element (i, j) is at position[i] + j
  std::size_t elements = 0;

  template <class T>
  MOMENTREE_INLINE T element(const std::vector<T>& A, std::size_t i, std::size_t j) const {
    const std::size_t row = i < j ? j : i, column = i < j ? i : j;
    if (static_cast<int>(column) < begin[row]) return T(0);
    return A[static_cast<std::size_t>(position[row] + static_cast<std::ptrdiff_t>(column))];
  }
};

/// Scratch of the choice of rows: a factorisation that takes rows in any order. The factor's row k has the elements from begin[k]
/// to the diagonal, the first one at F[start[k]].
struct RowChoice {
  std::vector<int> taken, begin, postponed;
  std::vector<int> taken_before;  ///< by loop: how many rows were taken when its own came first
  std::vector<std::size_t> start;
  std::vector<double> F, trial, remainder, scale;
  std::vector<double> mobility;  ///< by chosen row: its element of A when it was chosen; behind these as many for scratch

  /// `elements`: of the layout of all rows. Rows that are taken late have longer rows of the factor.
  void reserve(std::size_t loops, std::size_t rows, std::size_t elements) {
    taken.reserve(rows), begin.reserve(rows), postponed.reserve(rows), start.reserve(rows), taken_before.resize(loops);
    F.reserve(std::min(rows * (rows + 1) / 2, 2 * elements + 64 * rows));
    trial.resize(6 * rows), remainder.resize(6), scale.resize(rows), mobility.resize(2 * rows);
  }
};

/// Scratch of find_least_reactions. It grows where fewer rows are independent than before.
struct LoopReactions {
  /// A wrench in world axes, about the world's origin or about a point.
  struct WorldWrench {
    Vec3 F{}, T{};
  };
  struct Carried {  ///< a joint, of a body or of a loop, and its wrench about its own point
    int body, loop;
    Vec3 at;
    WorldWrench now;
  };
  std::vector<double> null;          ///< multipliers without effect, one after the other
  std::vector<double> lambda, G, c;  ///< multipliers at first; the system of the least reactions
  std::vector<WorldWrench> by_body, by_loop;
  std::vector<double> by_null;       ///< what null vectors add to the joints
  std::vector<std::size_t> nonzero;  ///< of a row of by_null
  std::vector<Carried> joints;
};

/// The part of the rows' system that is not computed with its scalar. For packs, `turns` and `motions` have one entry per lane,
/// those of one loop consecutive.
struct LoopConstants {
  std::uint64_t topology = 0;         ///< TreeLoops::revision() for which everything is laid out and rows were chosen; 0: none
  std::vector<Turns> turns;           ///< by loop: the angles to which its own are nearest
  std::vector<Curve::Point> motions;  ///< by loop: its prescribed motion at the time of the evaluation
  std::vector<double> extents;        ///< by loop: the least size for tolerances (m)
  LoopLayout all, kept;               ///< of all rows, and of the chosen ones
  bool whole = false;                 ///< A is that of all rows
  unsigned lanes = ~0u;               ///< those in use, a bit each; nothing is computed lane by lane for the others
};

/// The system of the rows, for any scalar.
template <class T>
struct LoopSystem : LoopConstants {
  std::vector<LoopPlaceOf<T>> places;    ///< by loop
  std::vector<LoopRowOf<T>> rows;        ///< by row
  std::vector<LoopColumnOf<T>> columns;  ///< by stop and row
  std::vector<T> A, factor;              ///< of all or of the chosen rows; Cholesky factor of the chosen ones
  std::vector<T> least_pivots;           ///< by chosen row: smaller ones are zero at stages; infinite: not chosen in that lane
  std::vector<T> b, lambda;              ///< by row; behind b as many for scratch
  std::vector<T> sizes;                  ///< by coupling that acts: of its equation, for tolerances (rad or m)
};

/// Coordinates and velocities of a loop joint.
struct LoopValues {
  double q[7] = {}, v[6] = {};
};

/// The impulse of a stop of a loop joint.
struct LoopStrike {
  int loop = -1;            ///< −1: none was struck
  Force<double> impulse{};  ///< on its child, world axes
};

/// Components of reactions that the loops leave open, as bits of ReactionParts: by body, and by link.
struct OpenReactions {
  std::vector<unsigned char> bodies, links;
};

struct LoopWorkspace : LoopSystem<double> {
  std::vector<ArmatureSpeed> carried;  ///< of loop joints with armature, before an impact
  RowChoice choice;
  std::vector<double> given;                     ///< by loop and DoF, 6 of each: efforts of functions in the last evaluation
  std::vector<LoopValues> values;                ///< by loop, for functions
  const double* efforts = nullptr;               ///< extra joint forces of a world of a batch, packed as p; null: none
  LoopRows wanted{};                             ///< of the evaluation in momenta that is going on
  ArmatureSpeeds armatures{};                    ///< of the same evaluation
  std::vector<double> speeds;                    ///< by row: of an armature at the start of the step, J H⁻¹ p
  std::vector<double> gauge;                     ///< by row: impulses that the last closing in momenta added to the momenta
  std::vector<double> u;                         ///< velocities, scratch of that closing
  std::vector<double> forces, answers;           ///< scratch of stages by generated code
  std::vector<Force<double>> momenta, wrenches;  ///< by body, scratch of rates of momenta
  int rank = 0;
  LoopStrike strike{};       ///< of the last change
  bool impulsive = false;    ///< the multipliers are impulses
  std::uint64_t solved = 0;  ///< Tree::revision() of the tree whose multipliers they are
  bool heavier = false;      ///< the evaluation is that of a tree with larger armatures than the rows were chosen for
  bool in_momenta = false;   ///< the present solution is that of an evaluation in momenta
  bool least = false;        ///< the multipliers are those of the least reactions
  LoopReactions reactions;
  OpenReactions open;
};

}  // namespace momentree
