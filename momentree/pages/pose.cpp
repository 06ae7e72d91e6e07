// The model in another pose.
#include <algorithm>
#include <cmath>

#include <momentree/joint/kinds/weld.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/pages/page_world.hpp>
#include <momentree/simulate/assembly.hpp>

namespace momentree::io {

namespace {

int coordinates(const Model& model, int j) { return info(model[{j}].joint.kind).nq; }

/// The model with its start at these coordinates. Joints whose coordinates differ from those before are held there, as welds, so
/// that closing the loops changes the others; couplings of two joints that are held, or of one that a polynomial leads, are
/// left out. `held`: by joint.
Model moved(const Model& model, const double* q, const double* before, std::vector<char>& held) {
  Model result;
  std::vector<double> now;  // by joint: its first coordinate
  for (int j = 0; j < model.size(); ++j) {
    BodySpec spec = model[BodyId{j}];
    const int n = coordinates(model, j);
    now.push_back(n > 0 ? q[0] : 0);
    held.push_back(!std::equal(q, q + n, before));
    spec.q = {}, spec.v = {};
    if (held.back()) {
      spec.at = spec.at * joint_motion(spec.joint, q);
      spec.joint = Weld{};
    } else {
      for (int i = 0; i < n; ++i) spec.q.push_back(q[i]);
    }
    result.add_unjudged(std::move(spec));
    q += n, before += n;
  }
  const auto is_held = [&held](JointId joint) { return joint.index >= 0 && held[static_cast<std::size_t>(joint.index)]; };
  for (Coupling coupling : model.couplings()) {
    const auto position = [&](JointId joint) { return now[static_cast<std::size_t>(joint.index)]; };
    if (is_held(coupling.joint)) {  // the other one follows, if it is free and its position is known at once
      const bool inverts = coupling.leads() && !is_held(coupling.follows) && coupling.multiplier != 0 &&
                           coupling.higher == std::array<double, 3>{};
      if (!inverts) continue;
      const double x = (position(coupling.joint) - coupling.offset) / coupling.multiplier;
      coupling = {.joint = coupling.follows, .offset = x};
    } else if (is_held(coupling.follows)) {
      coupling = {.joint = coupling.joint, .offset = coupling.value(position(coupling.follows))};
    }
    result.add_coupling(coupling);
  }
  for (LoopSpec loop : model.loops()) {
    loop.assemble = true;
    result.add_loop(std::move(loop));
  }
  return result;
}

std::vector<double> start_of(const World& world) {
  std::vector<double> all;
  for (int j = 0; j < world.model().size(); ++j)
    for (const double q : world.joint({j}).q) all.push_back(q);
  return all;
}

}  // namespace

void pose(const Model& model, const double* q, std::vector<double>& motions, std::vector<double>& posed) {
  const World start(model);
  if (posed.empty()) posed = start_of(start);
  if (motions.empty()) fill_motions(start, motions);
  if (!std::all_of(q, q + posed.size(), [](double x) { return std::isfinite(x); })) return;
  if (model.loops().empty()) {
    World world(model);
    std::vector<JointStart> joints;
    const double* next = q;
    for (int j = 0; j < model.size(); ++j) {
      JointStart& joint = joints.emplace_back(JointStart{{j}, {}, {}, {}});
      for (int i = 0; i < coordinates(model, j); ++i) joint.q.push_back(*next++);
      for (int i = 0; i < info(model[{j}].joint.kind).nv; ++i) joint.v.push_back(0);
    }
    world.restore(0, {}, joints);
    fill_motions(world, motions);
    posed = start_of(world);  // joints that are coupled follow others
    return;
  }
  std::vector<char> held;
  const Model other = moved(model, q, posed.data(), held);
  if (check_assembly(other)) return;
  const World world(other, Variables::velocities);
  fill_motions(world, motions);
  std::size_t place = 0;
  for (int j = 0; j < model.size(); ++j) {
    const Numbers own = world.joint({j}).q;
    for (int i = 0; i < coordinates(model, j); ++i, ++place)
      posed[place] = held[static_cast<std::size_t>(j)] ? q[place] : own[static_cast<std::size_t>(i)];
  }
}

}  // namespace momentree::io
