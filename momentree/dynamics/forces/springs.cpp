#include <momentree/dynamics/forces/springs.hpp>

#include <momentree/dynamics/forces/load_laws.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree {

namespace {

forces::SpringPoint<double> end_of(const Tree& tree, const Workspace<double>& workspace, const SpringEnd& end) noexcept {
  if (end.body == ground) return forces::spring_point<double>(end, nullptr, nullptr);
  return forces::spring_point(end, &tree.frame(end.body.index), &workspace.bodies[static_cast<std::size_t>(end.body.index)]);
}

// `force`: on the end, in world axes.
void pull(const Tree& tree, const SpringEnd& end, const Vec3& force, Workspace<double>& workspace) noexcept {
  if (end.body == ground) return;
  workspace.loads[static_cast<std::size_t>(end.body.index)] += forces::pull(end_of(tree, workspace, end), force);
}

}  // namespace

SpringMotion spring_motion(const Tree& tree, const Workspace<double>& workspace, int spring) noexcept {
  const Spring& s = tree.springs()[static_cast<std::size_t>(spring)];
  const forces::SpringPoint<double> from = end_of(tree, workspace, s.from), to = end_of(tree, workspace, s.to);
  const forces::SpringStretch<double> stretch(from, to);
  return {from.place, to.place, stretch.direction, stretch.length, stretch.rate};
}

double spring_energy(const Tree& tree, const State& state, const Workspace<double>& workspace, int spring) noexcept {
  if (!spring_acts(tree, spring)) return 0;
  const auto place = [&](const SpringEnd& end) {
    if (end.body == ground) return end.point;
    const DenseTransform<double> body = locate_body(tree, state, workspace, end.body.index);
    const KernelFrame& frame = tree.frame(end.body.index);
    return body.r + body.R * transpose_times(frame.R, end.point - frame.r);
  };
  const Spring& s = tree.springs()[static_cast<std::size_t>(spring)];
  return tree.springs().law(spring).energy(norm(place(s.to) - place(s.from)));
}

void add_spring_loads(const Tree& tree, Workspace<double>& workspace) noexcept {
  for (int i = 0; i < tree.springs().count(); ++i) {
    if (!spring_acts(tree, i)) continue;
    const SpringLaw& law = tree.springs().law(i);
    const SpringMotion motion = spring_motion(tree, workspace, i);
    workspace.power.dissipated += law.dissipated(motion.length, motion.rate);
    const double tension = law.tension(motion.length, motion.rate);
    if (tension == 0 || !(motion.length > 0)) continue;
    const Spring& s = tree.springs()[static_cast<std::size_t>(i)];
    pull(tree, s.from, tension * motion.direction, workspace);
    pull(tree, s.to, -tension * motion.direction, workspace);
  }
}

}  // namespace momentree
