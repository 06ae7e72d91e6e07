// The model in another pose.
#include <algorithm>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/simulate/assembly.hpp>
#include <wasm/world.hpp>

namespace momentree::wasm {

namespace {

/// The nearest coordinates at which the loops are closed; false if there are none near by.
bool close_loops(const Model& model, std::vector<JointStart>& joints) {
  if (model.loops().empty()) return true;
  const Tree tree(model);
  State state(tree, Variables::velocities);
  {
    const State::Edit edit = state.edit();
    for (int j = 0; j < model.size(); ++j) {
      const Values& q = joints[static_cast<std::size_t>(j)].q;
      std::copy(q.begin(), q.end(), edit.q.begin() + tree.first_q(j));
    }
    follow_motions(tree, 0, edit.q.data(), edit.u.data());
    std::fill(edit.u.begin(), edit.u.end(), 0.0);
  }
  if (assemble(tree, model, Names(model), state)) return false;
  for (int j = 0; j < model.size(); ++j) {
    Values& q = joints[static_cast<std::size_t>(j)].q;
    for (int i = 0; i < q.size(); ++i) q[i] = state.q()[static_cast<std::size_t>(tree.first_q(j) + i)];
  }
  return true;
}

}  // namespace

void pose(const Model& model, const double* q, std::vector<double>& motions) {
  World posed(model);
  std::vector<JointStart> joints;
  for (int j = 0; j < model.size(); ++j) {
    const KindInfo& kind = info(model[{j}].joint.kind);
    JointStart& joint = joints.emplace_back(JointStart{{j}, {}, {}, {}});
    for (int i = 0; i < kind.nq; ++i) joint.q.push_back(*q++);
    for (int i = 0; i < kind.nv; ++i) joint.v.push_back(0);
  }
  if (close_loops(model, joints))
    posed.restore(0, {}, joints);
  else if (!motions.empty())
    return;
  fill_motions(posed, motions);
}

}  // namespace momentree::wasm
