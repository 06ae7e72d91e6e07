#pragma once
// An independent oracle of the dynamics of trees, in long double, based on forward kinematics only: no joint matrices, no spatial
// algebra, no recursion over momenta. Its only input from the engine are the model and the public data of a World.
//
// Velocities are those of the documentation: coordinate rates, except for a ball joint the angular velocity of the child relative
// to the parent in child-side axes, and for a free joint the linear velocity of the child-side origin in front of that. Momenta,
// rates and velocities are ordered by body number, starting with body 0.
#include <vector>

#include <momentree/model/model.hpp>
#include <tests/oracle/jet.hpp>

namespace momentree {
class World;
}

namespace momentree::oracle {

/// One body with its joint, as in a BodySpec.
struct Link {
  int parent = -1;
  JointSpec joint;
  Pose at, child_at;
  double mass = 0;
  Vec3 com;
  Sym3 inertia;
};

/// A forest and its present coordinates.
struct System {
  V3<Real> gravity{};
  Real time = 0;  ///< for drives
  std::vector<Link> links;
  std::vector<int> first_q, first_v;  ///< per link, with the totals at the end
  int nq() const { return first_q.back(); }
  int nv() const { return first_v.back(); }
};

/// Fills first_q and first_v.
void number(System& system);
/// The system that a model describes, and its start.
System system_of(const Model& model);
std::vector<double> start_q(const Model& model);
std::vector<double> start_v(const Model& model);
/// The present system of a world: topology, placements and joints from its public data.
System system_of(const World& world);

/// The system after the inboard joint of `body` broke: a free joint to the ground at the body's own frame, without parameters.
System broken(System system, int body);

/// Number of coordinates and of DoFs of a joint kind, according to the documentation.
int coordinates(Kind kind);
int dofs(Kind kind);

/// Lower triangle of a symmetric matrix with entries only between a DoF and its ancestors.
class MassMatrix {
 public:
  explicit MassMatrix(int n) : n_(n), at_(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
  int size() const { return n_; }
  Real& operator()(int i, int j) { return at_[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_) + j]; }
  Real operator()(int i, int j) const { return at_[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_) + j]; }
  std::vector<Real> times(const std::vector<Real>& v) const;

 private:
  int n_;
  std::vector<Real> at_;  // full storage, both triangles
};

/// M(q), from the Jacobians of centres of mass and attitudes by dual numbers; including armature.
MassMatrix mass_matrix(const System& system, const std::vector<double>& q);
/// x with M x = p, by Cholesky factors in long double, which preserve the zeros of a tree.
std::vector<Real> solve(const MassMatrix& mass, const std::vector<Real>& p);
struct Spectrum {
  double smallest = 0, largest = 0;
  double condition() const;  ///< infinite if the smallest eigenvalue is lost in round-off
};
/// Extreme eigenvalues, in double.
Spectrum spectrum(const MassMatrix& mass);

/// All results for the system at one state.
struct Evaluation {
  std::vector<Real> pdot;
  std::vector<Real> pdot_alembert;  ///< by d'Alembert's principle, which needs no Hamel terms
  Real kinetic = 0, potential = 0;
  V3<Real> linear{}, angular{};
  struct Motion {
    Frame<Real> frame;  ///< of the body
    V3<Real> com{}, com_velocity{};
    V3<Real> velocity{}, angular{};  ///< of the frame's origin; world axes
  };
  std::vector<Motion> motions;
};
/// All results at (q, v). `with_rates` = false omits the rates, which are the expensive part.
Evaluation evaluate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, bool with_rates = true);

/// Accelerations and joint wrenches at (q, v), by the second derivative of forward kinematics and the Newton–Euler equations of
/// each body. `locked`: DoFs whose acceleration is `given` (empty: they stay at rest); empty: none.
struct Accelerations {
  std::vector<Real> v;  ///< time derivatives of the velocities
  struct Body {
    V3<Real> linear{}, angular{};  ///< of the frame's origin; world axes
    V3<Real> force{}, torque{};    ///< of the inboard joint on the body, about the frame's origin, in its axes
  };
  std::vector<Body> bodies;
  Real summands = 0;  ///< norm of the v̇ that the forces would cause if they did not cancel
};
Accelerations accelerate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, const MassMatrix& mass,
                         const std::vector<char>& locked = {}, const std::vector<Real>& given = {});

/// Force of each DoF at the system's time: drives, dampers, springs, friction, soft stops; without prescribed motions.
std::vector<Real> joint_forces(const System& system, const std::vector<double>& q, const std::vector<Real>& v);
/// Value and first two derivatives of a signal at t; tables are piecewise linear.
Curve signal_at(const Signal& signal, Real t);
/// Energy of gravity, springs and soft stops.
Real potential(const System& system, const std::vector<double>& q);

/// Generalised velocity directions in the body's own frame: column i is the motion (linear; angular, in body axes at the origin
/// of the body's frame) that DoF i of the joint of `link` causes in its child. For the law p = Eᵀ P.
std::vector<std::array<Real, 6>> joint_columns(const System& system, const std::vector<double>& q, int link);

/// `q` moved with velocities `v` for `h` seconds, at least to second order (exact for constant v). For finite-difference checks.
std::vector<double> displaced(const System& system, const std::vector<double>& q, const std::vector<Real>& v, Real h);

}  // namespace momentree::oracle
