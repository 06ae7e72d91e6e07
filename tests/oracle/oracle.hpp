#pragma once
// An independent oracle of the dynamics of trees, in long double, from forward kinematics alone: no joint matrices, no spatial
// algebra, no recursion over momenta. Its only input from the engine are the model and what a World publishes.
//
// Velocities follow the contract: true coordinate rates, but for a ball the angular velocity of the child relative to the parent
// in child-side axes, and for a free joint the linear velocity of the child-side origin before it.
// Momenta, rates and velocities are indexed by body number: those of body 0 first.
#include <vector>

#include <momentree/tree/model.hpp>
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

/// A forest and where its coordinates stand.
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
/// The system that a world is at present: topology, placements and joints from what it publishes.
System system_of(const World& world);

/// The system after the inboard joint of `body` broke: a free joint to the ground at the body's own frame, without parameters.
System broken(System system, int body);

/// Number of coordinates and of freedoms of a kind, by the contract.
int coordinates(Kind kind);
int dofs(Kind kind);

/// Lower triangle of a symmetric matrix, entries only between a freedom and its ancestors.
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

/// M(q), from the Jacobians of centres of mass and attitudes by dual numbers; armature included.
MassMatrix mass_matrix(const System& system, const std::vector<double>& q);
/// x with M x = p, by Cholesky's factors in long double, which keep the zeros of a tree.
std::vector<Real> solve(const MassMatrix& mass, const std::vector<Real>& p);
struct Spectrum {
  double smallest = 0, largest = 0;
  double condition() const;  ///< infinite where the smallest is lost in round-off
};
/// Extreme eigenvalues, in double.
Spectrum spectrum(const MassMatrix& mass);

/// What is known of the system at one state.
struct Evaluation {
  std::vector<Real> pdot;
  std::vector<Real> pdot_alembert;  ///< the same by d'Alembert's principle, where no Hamel terms are needed
  Real kinetic = 0, potential = 0;
  V3<Real> linear{}, angular{};
  struct Motion {
    Frame<Real> frame;  ///< of the body
    V3<Real> com{}, com_velocity{};
    V3<Real> velocity{}, angular{};  ///< of the frame's origin; world axes
  };
  std::vector<Motion> motions;
};
/// Everything at (q, v). `with_rates` false leaves the rates out, which are the dear part.
Evaluation evaluate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, bool with_rates = true);

/// Accelerations and joint wrenches at (q, v), by the second derivative of forward kinematics and the equations of Newton and
/// Euler for each body. `locked`: freedoms whose acceleration is `given` (empty: they rest and stay so); empty: none.
struct Accelerations {
  std::vector<Real> v;  ///< time derivatives of the velocities
  struct Body {
    V3<Real> linear{}, angular{};  ///< of the frame's origin; world axes
    V3<Real> force{}, torque{};    ///< of the inboard joint on the body, about the frame's origin, in its axes
  };
  std::vector<Body> bodies;
  Real summands = 0;  ///< norm of the v̇ that forces would give which did not cancel
};
Accelerations accelerate(const System& system, const std::vector<double>& q, const std::vector<Real>& v, const MassMatrix& mass,
                         const std::vector<char>& locked = {}, const std::vector<Real>& given = {});

/// Force of each freedom at the system's time: drives, dampers, springs, friction, soft stops; nothing of prescribed motions.
std::vector<Real> joint_forces(const System& system, const std::vector<double>& q, const std::vector<Real>& v);
/// Value and first two derivatives at t of a signal: of tables the straight lines.
Curve signal_at(const Signal& signal, Real t);
/// Energy of gravity, springs and soft stops.
Real potential(const System& system, const std::vector<double>& q);

/// Generalized velocity directions seen from the body's own frame: column i is the motion (linear; angular, body axes at the
/// origin of the body's frame) that freedom i of the joint of `link` gives its child. For the law p = Eᵀ P.
std::vector<std::array<Real, 6>> joint_columns(const System& system, const std::vector<double>& q, int link);

/// `q` moved along velocities `v` for `h` seconds, to second order at least (exact where v is constant). For checks by
/// differences.
std::vector<double> displaced(const System& system, const std::vector<double>& q, const std::vector<Real>& v, Real h);

}  // namespace momentree::oracle
