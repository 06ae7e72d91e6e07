#include <momentree/simulate/analysis/configuration.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/joint/link_constants.hpp>

namespace momentree::analysis {

Configuration::Configuration(const World& world) : tree_(&world.tree()), state_(world.state()), workspace_(world.tree()) {
  const State::Edit edit = state_.edit();
  std::fill(edit.y.begin(), edit.y.end(), 0.0);
}

bool Configuration::set(const std::vector<double>& q) {
  std::vector<double> closed = q;
  if (tree_->has_loops()) {
    std::vector<double> u(at(nv()));
    double energy = 0;
    load_turns(*tree_, state_, workspace_);
    if (!close_loops(*tree_, state_.time(), closed.data(), u.data(), workspace_, energy)) return false;
    if (!loops_within_limits(closed.data())) return false;
    state_.set_turns(workspace_.loops->turns);
  }
  const State::Edit edit = state_.edit();
  std::copy(closed.begin(), closed.end(), edit.q.begin());
  return true;
}

bool Configuration::loops_within_limits(const double* q) {
  constexpr double rounding = 1e-9;
  const std::vector<Turns> turns = workspace_.loops->turns;
  const std::vector<double> rest(at(nv()));
  for (std::size_t i = 0; i < tree_->loops().size(); ++i) {
    const Loop& loop = tree_->loops()[i];
    if (!loop.parameters.limits.hard()) continue;
    double own[7] = {}, u[6] = {};
    loop_joint_values(*tree_, state_.time(), q, rest.data(), turns, workspace_, static_cast<int>(i), own, u);
    for (int k = 0; k < info(loop.joint.kind).nv; ++k)
      if (own[k] < loop.parameters.limits.lower_of(k) - rounding || own[k] > loop.parameters.limits.upper_of(k) + rounding)
        return false;
  }
  workspace_.loops->turns = turns;
  return true;
}

bool Configuration::displace(const std::vector<double>& step) {
  std::vector<double> q(state_.q().begin(), state_.q().end());
  momentree::displace(*tree_, step.data(), q.data());
  return set(q);
}

std::vector<bool> Configuration::held() const {
  std::vector<bool> held(at(nv()));
  for (const int b : tree_->order())
    for (int i = 0; i < info(tree_->kind(b)).nv; ++i) held[at(tree_->first_p(b) + i)] = (tree_->link(b).locked >> i & 1u) != 0;
  return held;
}

std::vector<double> Configuration::accelerations() {
  accelerate(*tree_, state_, workspace_);
  std::vector<double> a(workspace_.a.get(), workspace_.a.get() + nv());
  const std::vector<bool> still = held();
  for (std::size_t i = 0; i < a.size(); ++i)
    if (still[i]) a[i] = 0;
  return a;
}

DenseMatrix Configuration::projection() {
  const std::vector<bool> still = held();
  DenseMatrix P(nv(), nv());
  if (tree_->has_loops()) accelerate(*tree_, state_, workspace_);  // chooses the rows of the loops
  const std::vector<double> rest(at(nv())), q(state_.q().begin(), state_.q().end());
  for (int j = 0; j < nv(); ++j) {
    if (still[at(j)]) continue;
    std::vector<double> step(at(nv()));
    step[at(j)] = 1;
    if (tree_->has_loops()) keep_loops_closed(*tree_, state_.time(), q.data(), rest.data(), step.data(), workspace_);
    for (int i = 0; i < nv(); ++i)
      if (!still[at(i)]) P(i, j) = step[at(i)];
  }
  return P;
}

bool Configuration::exact() const { return not_differentiable(*tree_, workspace_).part == NotDifferentiable::Part::none; }

DenseMatrix Configuration::slopes() {
  DenseMatrix K(nv(), nv());
  accelerate(*tree_, state_, workspace_);
  if (exact()) {
    AccelerationTangent tangent(*tree_);
    tangent.prepare(*tree_, state_, workspace_);
    std::vector<double> unit(at(nv()) * at(nv())), columns(unit.size());
    for (int j = 0; j < nv(); ++j) unit[at(j) * at(nv() + 1)] = 1;
    std::vector<double> rest(unit.size());
    tangent.allow(nv(), unit.data(), rest.data());
    tangent.along(nv(), unit.data(), nullptr, columns.data());
    for (int i = 0; i < nv(); ++i)
      for (int j = 0; j < nv(); ++j) K(i, j) = columns[at(j) * at(nv()) + at(i)];
    return K;
  }
  return differences(projection(), [this] { return accelerations(); });
}

DenseMatrix Configuration::differences(const DenseMatrix& P, const std::function<std::vector<double>()>& f, double width) {
  DenseMatrix K(nv(), nv());
  const State here = state_;
  for (int j = 0; j < nv(); ++j)
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> step(at(nv()));
      for (int i = 0; i < nv(); ++i) step[at(i)] = sign * width * P(i, j);
      if (displace(step)) {
        const std::vector<double> value = f();
        for (int i = 0; i < nv(); ++i) K(i, j) += sign * value[at(i)] / (2 * width);
      }
      state_ = here;
    }
  return K;
}

DenseMatrix Configuration::mass() {
  DenseMatrix M(nv(), nv());
  mass_matrix(*tree_, state_, workspace_, M.numbers.data());
  const std::vector<bool> still = held();
  for (int i = 0; i < nv(); ++i)
    for (int j = 0; j < nv(); ++j)
      if (still[at(i)] || still[at(j)]) M(i, j) = i == j ? 1 : 0;
  return M;
}

Bounds bounds_of(const Tree& tree, int body, int dof) {
  const JointParameters* const p = tree.parameters(body);
  if (p == nullptr || !p->limits.hard()) return {-HUGE_VAL, HUGE_VAL};
  return {p->limits.lower_of(dof), p->limits.upper_of(dof)};
}

}  // namespace momentree::analysis
