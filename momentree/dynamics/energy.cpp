#include <momentree/dynamics/user_frames.hpp>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/soft_stop.hpp>
#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/dynamics/loops/loops.hpp>

namespace momentree {

namespace {
double stop_energy(const Tree& tree, const State& state, int b) noexcept {
  const JointParameters* p = tree.parameters(b);
  if (p == nullptr || !p->limits.soft()) return 0;
  return forces::soft_stop_energy(*p, info(tree.kind(b)).nv, state.q().data() + tree.first_q(b));
}
}  // namespace

Totals totals(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  locate_bodies(tree, state, workspace);
  Totals sum;
  const Vec3& g = tree.gravity();
  for (int b = 0; b < tree.bodies(); ++b) {
    if (!tree.alive(b)) continue;
    const Kinematics<double>& body = workspace.bodies[static_cast<std::size_t>(b)];
    const RigidMass& mass = tree.link(b).body;
    const Force<double> P = momentum(mass, body.velocity);  // (4)
    const Vec3 l = body.R * P.l;
    sum.kinetic += 0.5 * dot(body.velocity, P);  // (11)
    sum.potential -= mass.m * dot(g, body.r) + dot(g, body.R * mass.mc);
    sum.linear += l;
    sum.angular += body.R * P.h + cross(body.r, l);
  }
  for (int i = 0; i < tree.nv(); ++i)
    sum.kinetic +=
        0.5 * tree.tables().armature[i] * workspace.v[static_cast<std::size_t>(i)] * workspace.v[static_cast<std::size_t>(i)];
  double force[6];
  for (int b : tree.joints_with().springs) sum.potential += joint_spring(tree, state.q().data(), b, force);
  for (int b : tree.joints_with().forces) sum.potential += stop_energy(tree, state, b);
  if (tree.has_loops()) sum.loops = loop_status(tree, state, workspace);
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    sum.potential += loop_energy(tree, workspace, static_cast<int>(i));
    sum.kinetic += loop_armature_energy(tree, workspace, static_cast<int>(i));
  }
  for (int s = 0; s < tree.springs().count(); ++s)
    if (spring_acts(tree, s)) sum.potential += tree.springs().law(s).energy(spring_motion(tree, workspace, s).length);
  return sum;
}

double joint_energy(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  double energy = 0, force[6];
  const JointParameters* p = tree.parameters(b);
  if (p != nullptr && p->stiffness.any()) energy += joint_spring(tree, state.q().data(), b, force);
  energy += stop_energy(tree, state, b);
  const int at = tree.first_p(b);
  for (int i = at; i < at + info(tree.kind(b)).nv; ++i)
    energy +=
        0.5 * tree.tables().armature[i] * workspace.v[static_cast<std::size_t>(i)] * workspace.v[static_cast<std::size_t>(i)];
  return energy;
}

Pose user_pose(const Tree& tree, const Mat3& kernel_R, const Vec3& kernel_r, int b) noexcept {
  const KernelFrame& f = tree.frame(b);
  const Mat3 R = kernel_R * transpose(f.R);
  return {kernel_r - R * f.r, quaternion_of(R)};
}

BodyMotion user_motion(const Tree& tree, const Kinematics<double>& body, int b) noexcept {
  BodyMotion m;
  m.pose = user_pose(tree, body, b);
  m.angular = body.R * body.velocity.w;
  m.linear = body.R * body.velocity.v + cross(m.angular, m.pose.position - body.r);
  return m;
}

}  // namespace momentree
