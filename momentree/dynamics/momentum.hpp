#pragma once
// Momenta: of bodies, articulated, and conjugate to the joint velocities (12), (14), (19).
#include <span>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>

namespace momentree {

/// Computes p from v, both packed (nv), at coordinates q: one outward pass for Ω, one inward pass for Pb. p = Eᵀ Pb + armature·v
/// (19); for a prescribed motion p is the rate v. For set-up only: allocates.
void project_momentum(const Tree& tree, const double* q, const double* v, double* p);

/// Working memory of project_momentum, by body: the same for any number of calls.
struct ProjectionBuffers {
  std::vector<Motion<double>> velocity;
  std::vector<Force<double>> momenta;
  std::vector<DenseTransform<double>> transforms;
};
/// The same; allocates only if `buffers` were used for fewer bodies or not at all.
void project_momentum(const Tree& tree, const double* q, const double* v, double* p, ProjectionBuffers& buffers);

/// For a new body b: sets p of its joint and adds b's momentum to p of all joints inboard, so that no velocity changes. `parent`:
/// velocity of the parent in the parent's kernel frame; v: of the new joint. Reads q but no workspace; p is the packed array.
void add_momentum(const Tree& tree, const double* q, int b, const Motion<double>& parent, const double* v, double* p) noexcept;

/// Articulated momentum Pb (14), of body b and all outboard bodies, in b's kernel frame. Requires a workspace evaluated on this
/// state.
[[nodiscard]] Force<double> articulated_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept;

/// Pose of body b's kernel frame in the world, O(depth). Requires a workspace evaluated on this state.
[[nodiscard]] DenseTransform<double> locate_body(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept;

/// (29): removes (sign −1) or adds (+1) the momentum W, in the kernel frame of body b, from or to the articulated momenta of b's
/// ancestors: their p change by sign·Eᵀ W. p is the packed array to change; O(depth). Reads only q and the workspace's
/// trigonometry, which must be of this state (p may be the state's own, under edit).
void shed_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace, int b, Force<double> W, double sign,
                   double* p) noexcept;

/// Changes p of b's joint by sign·Eᵀ W, except for locked and driven DoFs; p is the packed array, W in the kernel frame of b.
void absorb(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double sign, double* p) noexcept;
/// Writes the columns of E of b's joint, in the kernel frame of b: at most 6. Returns how many.
int columns_of(const Tree& tree, int b, const JointState<double>& joint, Motion<double>* columns) noexcept;
/// Writes Eᵀ W of b's joint (nv numbers), W in the kernel frame of b.
void project(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double* p) noexcept;
/// Momentum or wrench of body b: from its kernel frame to its user frame, and back.
Force<double> to_user_frame(const KernelFrame& frame, const Force<double>& P) noexcept;
Force<double> to_kernel_frame(const KernelFrame& frame, const Force<double>& P) noexcept;

}  // namespace momentree
