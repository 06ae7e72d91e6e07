// Removing and adding bodies.
#include <algorithm>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/model/start.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

Released apply(const Remove& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = change.body.index;
  MT_REQUIRE(state.topology() == tree.revision(), foreign_state);
  MT_REQUIRE(floats(tree, {b}) && tree.parent(b) < 0, "the body is the root of a mechanism that floats: break it off first");
  MT_REQUIRE(tree.bodies() <= workspace.capacity(), "the workspace has room for the tree's bodies: construct a new one");
  for (int x : tree.order()) {  // inboard before outboard
    const int outer = tree.parent(x);
    workspace.path[static_cast<std::size_t>(x)] = x == b || (outer >= 0 && workspace.path[static_cast<std::size_t>(outer)] != 0);
  }
  {
    const State::Edit edit = state.edit();
    double *q = edit.q.data(), *y = edit.y.data();
    for (int j = 0; j < tree.bodies(); ++j) {  // compacts q and y, in the order of joints
      const int x = tree.carrier(j);
      if (x < 0 || workspace.path[static_cast<std::size_t>(x)] != 0) continue;
      const KindInfo& kind = info(tree.kind(x));
      q = std::copy_n(edit.q.data() + tree.first_q(x), kind.nq, q);
      y = std::copy_n(edit.y.data() + tree.first_p(x), kind.nv, y);
    }
  }
  for (std::size_t i = tree.loops().size(); i-- > 0;) {  // they go with their bodies
    const Loop& loop = tree.loops()[i];
    const auto goes = [&](int x) { return x >= 0 && workspace.path[static_cast<std::size_t>(x)] != 0; };
    if (goes(loop.body) || goes(loop.to)) state.remove_turns(i);
  }
  tree.edit().remove(b);
  const int gone_q = static_cast<int>(state.q().size()) - tree.nq(), gone_p = static_cast<int>(state.y().size()) - tree.nv();
  state.replace(tree.nq(), gone_q, {}, tree.nv(), gone_p, {}, tree);
  return {};
}

BodyId apply(const Add& change, Tree& tree, State& state, const Workspace<double>& workspace) {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(change.spec != nullptr, "a body to add");
  const BodySpec& spec = *change.spec;
  const KindInfo& kind = info(spec.joint.kind);
  MT_REQUIRE(check_body(spec).empty(), "a valid body, according to check_body()");
  const Values q = start_coordinates(spec);
  double v[6] = {};
  std::copy_n(spec.v.begin(), spec.v.size(), v);
  const int outer = spec.parent.index;
  Motion<double> motion{};
  MT_REQUIRE(outer == ground.index || tree.alive(outer), "the parent is the ground or in the tree");
  if (outer >= 0) {
    const KernelFrame& frame = tree.frame(outer);
    const Motion<double>& own = workspace.motions[static_cast<std::size_t>(outer)].velocity;
    motion = {frame.R * own.v, frame.R * own.w};
    motion.v += cross(frame.r, motion.w);
  }
  const int nq = tree.nq(), nv = tree.nv();
  const int b = tree.edit().add(spec);
  const double none[6] = {};
  state.replace(nq, 0, {q.begin(), static_cast<std::size_t>(kind.nq)}, nv, 0, {none, static_cast<std::size_t>(kind.nv)}, tree);
  if (outer >= 0) {  // as its parent's first child, b may have rotated the parent's kernel frame about its joint and shifted it
                     // along the axis
    const KernelFrame& frame = tree.frame(outer);
    motion = {transpose_times(frame.R, motion.v + cross(motion.w, frame.r)), transpose_times(frame.R, motion.w)};
  }
  const State::Edit edit = state.edit();
  if (state.variables() == Variables::velocities) {
    for (int i = 0; i < kind.nv; ++i) edit.u[static_cast<std::size_t>(nv + i)] = v[i];
    return {b};
  }
  add_momentum(tree, edit.q.data(), b, motion, v, edit.p.data());
  return {b};
}

}  // namespace momentree
