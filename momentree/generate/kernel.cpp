#include <momentree/generate/kernel.hpp>

#include <new>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/linear_spring.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/generate/recording.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

// In instantiate/.
extern template void evaluate_rates<Symbolic>(const Tree&, const Symbolic*, const Symbolic*, Workspace<Symbolic>&) noexcept;
extern template void sweep_velocities<Symbolic, false>(const Tree&, const Symbolic*, const Symbolic*,
                                                       Workspace<Symbolic>&) noexcept;
extern template void solve_accelerations<Symbolic, false>(const Tree&, const Symbolic*, Workspace<Symbolic>&,
                                                          const Motion<Symbolic>&) noexcept;

using detail::resting, detail::take;

std::vector<int> KernelExpressions::rows() const {
  std::vector<int> all;
  int before = 0;
  for (int i = 0; i < static_cast<int>(begin.size()); ++i) {
    const int first = begin[static_cast<std::size_t>(i)];
    all.push_back(before - first);
    before += i + 1 - first;
  }
  return all;
}

std::vector<int> KernelExpressions::results() const {
  std::vector<int> all = v;
  all.insert(all.end(), qdot.begin(), qdot.end());
  all.insert(all.end(), pdot.begin(), pdot.end());
  all.insert(all.end(), udot.begin(), udot.end());
  all.insert(all.end(), lambda.begin(), lambda.end());
  all.insert(all.end(), effort.begin(), effort.end());
  return all;
}

KernelExpressions kernel_expressions(const Tree& tree) {
  using T = Symbolic;
  KernelExpressions kernel;
  Expressions& all = kernel.expressions;
  T::graph() = &all;
  std::vector<T> q, p;
  for (int i = 0; i < tree.nq(); ++i) q.push_back(T::of_node(all.input(Operation::q, i)));
  for (int i = 0; i < tree.nv(); ++i) p.push_back(T::of_node(all.input(Operation::p, i)));
  Workspace<T> workspace(tree);
  detail::record_steps(tree, Variables::momenta, workspace);
  evaluate_rates(tree, q.data(), p.data(), workspace);
  take(workspace.v, tree.nv(), kernel.v);
  take(workspace.qdot, tree.nq(), kernel.qdot);
  take(workspace.pdot, tree.nv(), kernel.pdot);
  T::graph() = nullptr;
  if (all.exhausted()) throw std::bad_alloc();
  return kernel;
}

KernelExpressions velocity_expressions(const Tree& tree, bool plain_forces) {
  using T = Symbolic;
  KernelExpressions kernel;
  kernel.variables = Variables::velocities;
  Expressions& all = kernel.expressions;
  T::graph() = &all;
  const std::vector<bool> rests = resting(tree);
  std::vector<T> q, u;
  for (int i = 0; i < tree.nq(); ++i) q.push_back(T::of_node(all.input(Operation::q, i)));
  for (int i = 0; i < tree.nv(); ++i)
    u.push_back(rests[static_cast<std::size_t>(i)] ? T(0) : T::of_node(all.input(Operation::p, i)));
  Workspace<T> workspace(tree);
  detail::record_steps(tree, Variables::velocities, workspace);
  sweep_velocities<T, false>(tree, q.data(), u.data(), workspace);
  for (int i = 0; i < tree.nv(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    T& tau = workspace.a[k];
    tau = rests[k] ? T(0) : T::of_node(all.input(Operation::tau, i));
    if (plain_forces && !rests[k]) tau += tree.tables().effort[k] - tree.tables().damping[k] * u[k];
  }
  if (plain_forces)
    for (const forces::LinearSpring& spring : forces::linear_springs(tree))
      workspace.a[static_cast<std::size_t>(spring.p)] -= spring.stiffness * (q[static_cast<std::size_t>(spring.q)] - spring.rest);
  const Vec3& g = tree.gravity();
  solve_accelerations<T, false>(tree, q.data(), workspace, {{T(-g.x), T(-g.y), T(-g.z)}, {T(0), T(0), T(0)}});
  take(workspace.qdot, tree.nq(), kernel.qdot);
  take(workspace.a, tree.nv(), kernel.udot);
  T::graph() = nullptr;
  if (all.exhausted()) throw std::bad_alloc();
  return kernel;
}

void add_plain_forces(const Tree& tree, KernelExpressions& kernel) {
  MT_REQUIRE(kernel.variables == Variables::momenta, "expressions in momenta: velocity_expressions() adds its forces itself");
  Expressions& all = kernel.expressions;
  for (std::size_t i = 0; i < kernel.pdot.size(); ++i) {
    const int damper = all.product(all.constant(tree.tables().damping[i]), kernel.v[i]);
    kernel.pdot[i] = all.difference(all.sum(kernel.pdot[i], all.constant(tree.tables().effort[i])), damper);
  }
  for (const forces::LinearSpring& spring : forces::linear_springs(tree)) {
    const int stretch = all.difference(all.input(Operation::q, spring.q), all.constant(spring.rest));
    int& pdot = kernel.pdot[static_cast<std::size_t>(spring.p)];
    pdot = all.difference(pdot, all.product(all.constant(spring.stiffness), stretch));
  }
}

std::vector<OtherForce> other_forces(const Tree& tree) {
  std::vector<OtherForce> found;
  for (const int b : tree.order()) {
    const auto has = [&](bool any, const char* what) {
      if (any) found.push_back({b, what, false});
    };
    has(tree.function(b) != nullptr, "a function that drives it");
    const JointParameters* p = tree.parameters(b);
    if (p == nullptr) continue;
    has(p->stiffness.any() && !forces::has_linear_springs(tree.kind(b)), "a spring about a quaternion");
    has(p->friction.any(), "dry friction");
    has(p->limits.soft(), "soft stops");
    if (p->drive == nullptr) continue;
    has(!p->drive->effort.empty(), "an effort that changes with time");
    has(p->drive->pd.any(), "position control");
    has(p->drive->moves(), "a prescribed motion");
  }
  const auto on_body = [&](int body, const char* what) {
    if (tree.alive(body)) found.push_back({body, what, true});
  };
  for (const BodyForce& force : tree.loads().forces) on_body(force.body.index, "a force that acts on it");
  for (int s = 0; s < tree.springs().count(); ++s)
    for (const SpringEnd* end :
         {&tree.springs()[static_cast<std::size_t>(s)].from, &tree.springs()[static_cast<std::size_t>(s)].to})
      if (spring_acts(tree, s) && end->body != ground) on_body(end->body.index, "a spring that pulls it");
  for (const Topology::Loaded& load : tree.loads().functions) on_body(load.body, "a function that acts on it");
  return found;
}

}  // namespace momentree
