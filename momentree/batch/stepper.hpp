#pragma once
// Steps of a block of worlds of one topology, one per lane. The same source is compiled for each instruction set.
#include <memory>
#include <optional>
#include <vector>

#include <momentree/dynamics/forces/linear_spring.hpp>
#include <momentree/dynamics/steps/step_scalar.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/math/isa.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// The precision of worlds in lanes. Their states are stored as doubles in either case.
enum class Precision : unsigned char { float64, float32 };

namespace batch {

/// The scalars of a plan's tables. A table whose scalar has size 0 is not made.
struct PlanScalars {
  StepScalar stage, kept;
};

/// What the steps of one topology are made of.
struct TopologyPlan {
  std::vector<forces::LinearSpring> springs;
  std::vector<int> elements;  ///< bodies whose joint has other forces, which are evaluated lane by lane
  OwnStepTable steps;         ///< of stages; null for worlds with loops
  OwnStepTable kept_steps;    ///< of passes that keep results
  /// `scalars`: of the stepper. Throws Error if there are too many bodies for it.
  TopologyPlan(const Tree& tree, const PlanScalars& scalars);
};

/// Worlds in lanes; number i of lane l is at [i·lanes + l].
struct Block {
  double *q, *y;              ///< packed, nq and nv numbers per lane; y: momenta or velocities
  const double* effort;       ///< extra efforts, packed as y; null: none
  double* time;               ///< s, by lane
  const double* h;            ///< s, by lane: the step of each world; 0: the world does not change, bit for bit
  unsigned char* diverged{};  ///< by lane: set if a step diverged; that world is left as before
  Turns* turns{};             ///< State::turns() of worlds with closed loops, those of one world consecutive
};

class Stepper {
 public:
  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;
  virtual ~Stepper();
  virtual int lanes() const = 0;
  /// For the plans of its topologies.
  virtual PlanScalars scalars() const = 0;
  /// One step of the classical Runge–Kutta method in every lane. The tree must not have more bodies than that of the constructor.
  /// Neither allocates nor throws.
  virtual void step(const Tree& tree, const TopologyPlan& plan, const Block& block) noexcept = 0;
};

/// Of worlds without loops.
class TreeStepper : public Stepper {
 public:
  ~TreeStepper() override;
  /// One evaluation without joint forces: q̇, ẏ (ṗ or u̇) and v of all lanes.
  virtual void rates(const Tree& tree, const TopologyPlan& plan, const double* q, const double* y, double* qdot, double* ydot,
                     double* v) noexcept = 0;
};

/// Of worlds with closed loops or exact couplings.
class LoopLanes : public Stepper {
 public:
  ~LoopLanes() override;
  /// Prepares steps of worlds with this tree. Allocates if they have more rows than before.
  virtual void fit(const Tree& tree) = 0;
};

/// Whether steps of worlds alone, or in lanes of a set, run as machine code in this process: the last bits depend on that.
bool makes_machine_code(std::optional<Isa> lanes) noexcept;
/// True if this library has kernels for the instruction set and this CPU can run them.
bool available(Isa isa) noexcept;
/// The widest available set up to `widest`; if the build has none of these, the narrowest that it has.
Isa best_isa(Isa widest = Isa::avx512) noexcept;
/// `variables`: what y is. Null if the set is not available.
std::unique_ptr<TreeStepper> make_stepper(Isa isa, Precision precision, const Tree& tree,
                                          Variables variables = Variables::momenta);

/// The same for worlds with loops, in velocities and doubles.
std::unique_ptr<LoopLanes> make_loop_lanes(Isa isa, const Tree& tree);

// Each in its own source file.
LoopLanes* make_baseline_loops(const Tree& tree);
LoopLanes* make_avx2_loops(const Tree& tree);
LoopLanes* make_avx512_loops(const Tree& tree);
TreeStepper* make_baseline_double(const Tree& tree);
TreeStepper* make_baseline_float(const Tree& tree);
TreeStepper* make_avx2_double(const Tree& tree);
TreeStepper* make_avx2_float(const Tree& tree);
TreeStepper* make_avx512_double(const Tree& tree);
TreeStepper* make_avx512_float(const Tree& tree);
TreeStepper* make_baseline_double_velocities(const Tree& tree);
TreeStepper* make_baseline_float_velocities(const Tree& tree);
TreeStepper* make_avx2_double_velocities(const Tree& tree);
TreeStepper* make_avx2_float_velocities(const Tree& tree);
TreeStepper* make_avx512_double_velocities(const Tree& tree);
TreeStepper* make_avx512_float_velocities(const Tree& tree);

// Computations done lane by lane, in double, the same for all instruction sets. q, u, force: those of b's joint alone.

/// Adds the forces of the plan's elements in b's joint at time t (s).
void add_element_forces(const Tree& tree, int b, double t, const double* q, const double* u, double* force) noexcept;
/// Writes position, rate and acceleration of b's prescribed motion at time t (s).
void motion_at(const Tree& tree, int b, double t, double* point) noexcept;
/// Normalises the quaternions of b's joint.
void normalise_joint(const Tree& tree, int b, double* q) noexcept;
/// Numbers of coordinates and of DoFs of b's joint.
int coordinates_of(const Tree& tree, int b) noexcept;
int dofs_of(const Tree& tree, int b) noexcept;

}  // namespace batch
}  // namespace momentree
