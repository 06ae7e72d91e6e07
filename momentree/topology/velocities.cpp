#include <momentree/topology/velocities.hpp>

#include <algorithm>

#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/joint_mass.hpp>
#include <momentree/math/sincos.hpp>

namespace momentree {

namespace {

// The kernel frame of b relative to its centre of mass, in the axes of its user frame. The momentum about the centre is that of
// the spin alone: about any other point, rounding the rest would turn a light body.
KernelFrame at_centre(const Tree& tree, int b) {
  const RigidMass& body = tree.link(b).body;
  const Mat3& R = tree.frame(b).R;
  return {R, body.m > 0 ? (-1 / body.m) * (R * body.mc) : Vec3{}};
}

}  // namespace

void carry_momenta(const Tree& tree, Workspace<double>& workspace) noexcept {
  for (const int b : tree.order()) {
    const auto i = static_cast<std::size_t>(b);
    workspace.carried[i] = to_user_frame(at_centre(tree, b), momentum(tree.link(b).body, workspace.motions[i].velocity));
  }
  if (tree.has_loops()) carry_armatures(tree, workspace);
}

void settle_velocities(const Tree& tree, State& state, Workspace<double>& workspace, int b) noexcept {
  for (const int x : tree.order()) {
    Force<double>& P = workspace.carried[static_cast<std::size_t>(x)];
    P = to_kernel_frame(at_centre(tree, x), P);
  }
  double* const u = workspace.impulse.get();
  std::copy_n(state.u().data(), tree.nv(), u);
  project_velocities(tree, state.q().data(), u, workspace, state.time());
  const State::Edit edit = state.edit();
  if (tree.has_loops()) {  // which may join several trees
    std::copy_n(u, tree.nv(), edit.u.data());
    return;
  }
  const int root = root_of(tree, {b}).index;
  for (const int x : tree.order()) {  // inboard before outboard
    const auto i = static_cast<std::size_t>(x);
    const int outer = tree.parent(x);
    workspace.path[i] = outer < 0 ? x : workspace.path[static_cast<std::size_t>(outer)];
    if (workspace.path[i] == root) std::copy_n(u + tree.first_p(x), info(tree.kind(x)).nv, edit.u.data() + tree.first_p(x));
  }
}

Motion<double> user_velocity(const Tree& tree, const Workspace<double>& workspace, int b) noexcept {
  if (b < 0) return {};
  const KernelFrame& frame = tree.frame(b);
  const Motion<double>& own = workspace.motions[static_cast<std::size_t>(b)].velocity;
  const Vec3 w = frame.R * own.w;
  return {frame.R * own.v + cross(frame.r, w), w};
}

void joint_velocities(const Tree& tree, int b, const double* q, const Motion<double>& own, const Motion<double>& outer,
                      double* u) noexcept {
  const auto to_kernel = [&](int body, const Motion<double>& a) {
    if (body < 0) return a;
    const KernelFrame& frame = tree.frame(body);
    return Motion<double>{transpose_times(frame.R, a.v + cross(a.w, frame.r)), transpose_times(frame.R, a.w)};
  };
  dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    using K = typename decltype(tag)::type;
    double c[2] = {}, s[2] = {};
    const auto angles = K::angles;
    for (std::size_t i = 0; i < angles.size(); ++i)
      sincos(q[angles[i]] + (K::rotates_about_z ? tree.link(b).angle_0 : 0.0), s[i], c[i]);
    const JointState<double> joint{q, c, s};
    const auto E = K::template columns<double>(tree.link(b), joint);
    constexpr int n = static_cast<int>(std::tuple_size_v<std::remove_cvref_t<decltype(E)>>);
    if constexpr (n > 0) {
      Motion<double> in = to_kernel(tree.parent(b), outer), relative = to_kernel(b, own);
      dense_transform<K, double>(tree.link(b), joint).outboard(in);
      relative = {relative.v - in.v, relative.w - in.w};
      if constexpr (requires { K::template offset<double>(tree.link(b)); }) {  // E is square
        K::template rates<double>(K::template offset<double>(tree.link(b)), relative, u);
        return;
      }
      const auto product = [](const Motion<double>& x, const Motion<double>& y) { return dot(x.v, y.v) + dot(x.w, y.w); };
      JointMass<double, n> squares;
      for (int i = 0; i < n; ++i) {
        const Motion<double>& e = E[static_cast<std::size_t>(i)];
        u[i] = product(e, relative);
        for (int j = 0; j <= i; ++j) squares(i, j) = product(e, E[static_cast<std::size_t>(j)]);
      }
      squares.factorise();
      squares.solve(u);
    }
  });
}

}  // namespace momentree
