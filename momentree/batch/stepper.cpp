#include <momentree/batch/stepper.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/elements.hpp>
#include <momentree/dynamics/steps/step_library.hpp>
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree::batch {

TopologyPlan::TopologyPlan(const Tree& tree, const PlanScalars& scalars)
    : springs(forces::linear_springs(tree)), elements(tree.joints_with().forces.begin(), tree.joints_with().forces.end()) {
  for (const int b : tree.joints_with().springs)
    if (!forces::has_linear_springs(tree.kind(b)) && std::find(elements.begin(), elements.end(), b) == elements.end())
      elements.push_back(b);
  const auto make = [&tree](const StepScalar& scalar, OwnStepTable& table) {
    if (scalar.size == 0) return;
    table = momentree::detail::make_step_table(scalar);
    if (!table->follow(tree))
      throw Error("mechanisms with " + std::to_string(tree.bodies()) + " bodies need more memory than lanes have", "",
                  "give each world a simulation of its own");
  };
  make(scalars.stage, steps), make(scalars.kept, kept_steps);
}

// Here, so that their tables are compiled for no wider instruction set.
Stepper::~Stepper() = default;
TreeStepper::~TreeStepper() = default;
LoopLanes::~LoopLanes() = default;

bool makes_machine_code(std::optional<Isa> lanes) noexcept {
  StepWidth width = StepWidth::one;
  if (lanes)
    width = *lanes == Isa::avx512 ? StepWidth::double_8 : *lanes == Isa::avx2 ? StepWidth::double_4 : StepWidth::double_2;
  return StepLibrary::of_process().available(width);
}

// Instruction sets of this build (MOMENTREE_LANES in CMakeLists.txt), with one definition each.
bool available([[maybe_unused]] Isa isa) noexcept {
#ifdef MOMENTREE_LANES_AVX512
  if (isa == Isa::avx512)
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
           __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("fma") != 0;
#endif
#ifdef MOMENTREE_LANES_AVX2
  if (isa == Isa::avx2) return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#endif
#ifdef MOMENTREE_LANES_BASELINE
  if (isa == Isa::baseline) return true;
#endif
  return false;
}

Isa best_isa(Isa widest) noexcept {
  for (int isa = static_cast<int>(widest); isa >= 0; --isa)
    if (available(static_cast<Isa>(isa))) return static_cast<Isa>(isa);
  for (int isa = static_cast<int>(widest) + 1; isa <= static_cast<int>(Isa::avx512); ++isa)
    if (available(static_cast<Isa>(isa))) return static_cast<Isa>(isa);
  return Isa::baseline;
}

namespace {

// One of the four steppers of an instruction set.
using Maker = TreeStepper* (*)(const Tree&);
[[maybe_unused]] std::unique_ptr<TreeStepper> made(const Tree& tree, Precision precision, Variables variables,
                                                   const Maker (&momenta)[2], const Maker (&velocities)[2]) {
  const int i = precision == Precision::float64 ? 0 : 1;
  return std::unique_ptr<TreeStepper>((variables == Variables::momenta ? momenta : velocities)[i](tree));
}

}  // namespace

std::unique_ptr<TreeStepper> make_stepper(Isa isa, [[maybe_unused]] Precision precision, [[maybe_unused]] const Tree& tree,
                                          [[maybe_unused]] Variables variables) {
  if (!available(isa)) return nullptr;
#define MOMENTREE_STEPPERS(set)                                                      \
  return made(tree, precision, variables, {make_##set##_double, make_##set##_float}, \
              {make_##set##_double_velocities, make_##set##_float_velocities})
#ifdef MOMENTREE_LANES_AVX512
  if (isa == Isa::avx512) MOMENTREE_STEPPERS(avx512);
#endif
#ifdef MOMENTREE_LANES_AVX2
  if (isa == Isa::avx2) MOMENTREE_STEPPERS(avx2);
#endif
#ifdef MOMENTREE_LANES_BASELINE
  if (isa == Isa::baseline) MOMENTREE_STEPPERS(baseline);
#endif
#undef MOMENTREE_STEPPERS
  return nullptr;
}

std::unique_ptr<LoopLanes> make_loop_lanes(Isa isa, [[maybe_unused]] const Tree& tree) {
#ifdef MOMENTREE_LANES_AVX512
  if (isa == Isa::avx512 && available(isa)) return std::unique_ptr<LoopLanes>(make_avx512_loops(tree));
#endif
#ifdef MOMENTREE_LANES_AVX2
  if (isa == Isa::avx2 && available(isa)) return std::unique_ptr<LoopLanes>(make_avx2_loops(tree));
#endif
#ifdef MOMENTREE_LANES_BASELINE
  if (isa == Isa::baseline) return std::unique_ptr<LoopLanes>(make_baseline_loops(tree));
#endif
  return nullptr;
}

void add_element_forces(const Tree& tree, int b, double t, const double* q, const double* u, double* force) noexcept {
  const JointParameters& p = *tree.parameters(b);
  const int nv = info(tree.kind(b)).nv;
  const unsigned locked = tree.joint(b).locked;
  if (p.stiffness.any() && !forces::has_linear_springs(tree.kind(b))) {
    double spring[6];
    joint_spring_at(tree, q, b, spring);
    for (int i = 0; i < nv; ++i)
      if ((locked >> i & 1u) == 0) force[i] += spring[i];
  }
  Power power;
  forces::add_elements({p, nv, ~locked, t, q, u, force, &power});
}

void motion_at(const Tree& tree, int b, double t, double* point) noexcept {
  const Curve::Point s = prescribed_motion(tree, b).at(t);
  point[0] = s.value, point[1] = s.rate, point[2] = s.acceleration;
}

void normalise_joint(const Tree& tree, int b, double* q) noexcept {
  dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::normalise(q); });
}

int coordinates_of(const Tree& tree, int b) noexcept { return info(tree.kind(b)).nq; }
int dofs_of(const Tree& tree, int b) noexcept { return info(tree.kind(b)).nv; }

}  // namespace momentree::batch
