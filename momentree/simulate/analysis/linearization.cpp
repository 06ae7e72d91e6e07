#include <momentree/simulate/analysis/linearization.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/simulate/analysis/configuration.hpp>

namespace momentree {

namespace {

using analysis::at;

void require_derivatives(const World& world, const Workspace<double>& workspace) {
  using Part = NotDifferentiable::Part;
  const NotDifferentiable what = not_differentiable(world.tree(), workspace);
  const auto refuse = [](const std::string& problem, const std::string& hint) { throw_error({problem, "", hint}); };
  bool cable = false;
  for (int s = 0; s < world.springs(); ++s) cable = cable || (world.spring({s}).inextensible && world.spring({s}).tension != 0);
  if (what.part == Part::contact || cable || !world.contacts().empty() ||
      (world.model().has_contact() && !world.constraints().active_limits.empty()))
    refuse("a world with closed contacts or taut cables cannot be linearised", "linearise where nothing touches");
  const Tree& tree = world.tree();
  analysis::each_coordinate(tree, [&](int b, int dof, int p, int q) {
    const analysis::Bounds bounds = analysis::bounds_of(tree, b, dof);
    const double x = world.state().q()[at(q)], a = workspace.a[at(p)];
    if ((tree.joint(b).locked >> dof & 1u) == 0 && ((x <= bounds.lower && a < 0) || (x >= bounds.upper && a > 0)))
      refuse("joint '" + std::string(world.joint_name(tree.inboard_joint({b}))) +
                 "' is pressed against its stop, which acts once a run has begun",
             "run the world for a moment, or lock the joint");
  });
  switch (what.part) {
    case Part::none:
    case Part::contact: return;
    case Part::loop_joint:
      return refuse("joint '" + std::string(world.joint_name(world.loops()[at(what.number)])) +
                        "' closes a loop and has forces, a motion, an armature or a lock, whose derivatives are not available",
                    "put these into a joint of the tree");
    case Part::joint_function:
      return refuse(
          "joint '" + std::string(world.joint_name(tree.inboard_joint({what.number}))) +
              "' is driven by a function, an elastic coupling or efforts that were written, whose derivatives are not known",
          "use drives and springs of joints, or remove it");
    case Part::body_function:
      return refuse(
          "a function acts on body '" + world.model().bodies()[at(what.number)].name + "', whose derivatives are not known",
          "use forces and springs of the model, or remove the function");
  }
}

}  // namespace

Linearization linearize(const World& world) {
  const Tree& tree = world.tree();
  const int nv = tree.nv();
  Linearization all{nv, DenseMatrix(2 * nv, 2 * nv), DenseMatrix(2 * nv, nv), DenseMatrix(2 * nv, 2 * nv)};
  const State state = world.state();
  Workspace<double> workspace(tree);
  accelerate(tree, state, workspace);
  require_derivatives(world, workspace);
  AccelerationTangent tangent(tree);
  tangent.prepare(tree, state, workspace);
  // Unit changes of the coordinates, then of the velocities, and the nearest ones that are allowed.
  const std::size_t n = at(nv), count = 2 * n;
  std::vector<double> dq(count * n), dv(count * n), da(count * n), rate(n), effort(n);
  for (std::size_t j = 0; j < n; ++j) dq[j * n + j] = dv[(n + j) * n + j] = 1;
  tangent.allow(2 * nv, dq.data(), dv.data());
  tangent.along(2 * nv, dq.data(), dv.data(), da.data());
  const std::vector<double> v(workspace.v.get(), workspace.v.get() + nv);
  const auto put = [&](int row, int column, const double* numbers, DenseMatrix& matrix) {
    for (int i = 0; i < nv; ++i) matrix(row + i, column) = numbers[i];
  };
  for (int j = 0; j < 2 * nv; ++j) {
    const std::size_t from = at(j) * n;
    displacement_rates(tree, v.data(), dq.data() + from, dv.data() + from, rate.data());
    put(0, j, rate.data(), all.A), put(nv, j, da.data() + from, all.A);
    put(0, j, dq.data() + from, all.projection), put(nv, j, dv.data() + from, all.projection);
  }
  // The velocities that impulses cause, closed loops included, are the accelerations that efforts cause.
  for (int j = 0; j < nv; ++j) {
    std::fill(effort.begin(), effort.end(), 0.0), std::fill(rate.begin(), rate.end(), 0.0);
    effort[at(j)] = 1;
    solve_mass(tree, state, workspace, effort.data(), effort.data());
    tangent.allow(1, rate.data(), effort.data());
    put(nv, j, effort.data(), all.B);
  }
  return all;
}

}  // namespace momentree
