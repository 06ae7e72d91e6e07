#include <momentree/dynamics/forces/body_forces.hpp>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/evaluation_context.hpp>
#include <momentree/dynamics/forces/load_laws.hpp>
#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

// Poses and velocities of the loaded bodies and of all bodies inboard of them; the places only for springs.
void move_loaded_bodies(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept {
  const bool places = tree.springs().count() > 0;
  for (const int b : tree.loads().bodies) {
    const int outer = tree.parent(b);
    Kinematics<double>& own = workspace.bodies[static_cast<std::size_t>(b)];
    own.velocity = outer < 0 ? Motion<double>{} : workspace.bodies[static_cast<std::size_t>(outer)].velocity;
    const JointState<double> joint = joint_state(tree, q, workspace, b);
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      const DenseTransform<double> x = dense_transform<K, double>(tree.link(b), joint);
      own.R = outer < 0 ? x.R : workspace.bodies[static_cast<std::size_t>(outer)].R * x.R;
      if (places) {
        const Kinematics<double>* const from = outer < 0 ? nullptr : &workspace.bodies[static_cast<std::size_t>(outer)];
        own.r = from == nullptr ? x.r : from->r + from->R * x.r;
      }
      x.outboard(own.velocity);
      own.velocity = K::template spatial_velocity<double>(tree.link(b), joint, own.velocity, workspace.v.get() + tree.first_p(b));
    });
  }
}

// The first query for a body through the context locates all bodies; the loaded ones get the values that they already have.
void call_functions(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept {
  const EvaluationContext context(tree, t, q, workspace);
  for (const Topology::Loaded& load : tree.loads().functions) {
    if (!tree.alive(load.body)) continue;
    const auto i = static_cast<std::size_t>(load.body);
    const Wrench given = (*load.function)(context);
    const KernelFrame& frame = tree.frame(load.body);
    const Kinematics<double>& body = workspace.bodies[i];
    Force<double> W{transpose_times(body.R, given.force), transpose_times(body.R, given.torque)};
    W.h += cross(transpose_times(frame.R, -frame.r), W.l);
    workspace.power.work += dot(body.velocity, W);
    workspace.loads[i] += W;
  }
}

}  // namespace

void find_loads(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept {
  const std::span<const int> loaded = tree.loads().bodies;
  if (loaded.empty()) return;
  move_loaded_bodies(tree, q, workspace);
  for (const int b : loaded) workspace.loads[static_cast<std::size_t>(b)] = {};
  for (const BodyForce& force : tree.loads().forces) {
    const int b = force.body.index;
    if (!tree.alive(b)) continue;
    const auto i = static_cast<std::size_t>(b);
    forces::PowerOf<double> power;
    workspace.loads[i] += forces::wrench_of(force, tree.frame(b), workspace.bodies[i], t, power);
    workspace.power.work += power.work, workspace.power.dissipated += power.dissipated;
  }
  add_spring_loads(tree, workspace);
  if (!tree.loads().functions.empty()) call_functions(tree, t, q, workspace);
}

void add_body_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept {
  const std::span<const int> loaded = tree.loads().bodies;
  if (loaded.empty()) return;
  find_loads(tree, t, q, workspace);
  Force<double>* const gathered = workspace.reduced_bias_wrenches.get();  // Tb; the array is stale until the next `accelerate`
  for (const int b : loaded) gathered[b] = workspace.loads[static_cast<std::size_t>(b)];
  for (std::size_t k = loaded.size(); k-- > 0;) {
    const int b = loaded[k], outer = tree.parent(b);
    const JointState<double> joint = joint_state(tree, q, workspace, b);
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      // (20) with u = 0 and Pb = 0 is Eᵀ Tb, and zero for locked DoFs.
      constexpr double at_rest[6] = {};
      double rate[6] = {};
      K::template momentum_rate<double>(tree.link(b), joint, at_rest, {}, gathered[b], rate);
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) workspace.pdot[static_cast<std::size_t>(tree.first_p(b) + i)] += rate[i];
      if (outer < 0) return;
      Force<double> W = gathered[b];
      K::template cached_transform<false, double>(tree.link(b), joint, workspace.record<K>(tree, b)).inboard(W);  // (16)
      gathered[outer] += W;
    });
  }
}

void clear_other_loads(const Tree& tree, Workspace<double>& workspace) noexcept {
  const std::span<const int> loaded = tree.loads().bodies;
  if (loaded.empty()) return;
  std::size_t k = 0;  // both lists are in the same order, inboard before outboard
  for (const int b : tree.order())
    if (k < loaded.size() && loaded[k] == b)
      ++k;
    else
      workspace.loads[static_cast<std::size_t>(b)] = {};
}

}  // namespace momentree
