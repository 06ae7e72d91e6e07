#include <momentree/dynamics/momentum.hpp>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sincos.hpp>
#include <momentree/model/start.hpp>

namespace momentree {

namespace {

template <class F>
decltype(auto) with_kernels(UncheckedTree tree, int b, F&& f) {
  return dispatch_kernels(tree.kind(b), tree.variant(b), std::forward<F>(f));
}

// Calls f with the transform of b's joint, in the form of its kind.
template <class F>
void cross_inboard(UncheckedTree tree, const State& state, const Workspace<double>& workspace, int b, F&& f) {
  with_kernels(tree, b, [&](auto tag) {
    using K = typename decltype(tag)::type;
    const JointState<double> joint = joint_state(tree, state.q().data(), workspace, b);
    f(K::template cached_transform<false, double>(tree.link(b), joint, workspace.record<K>(tree, b)));
  });
}

// Calls f(kernels, joint state), with trigonometry from the coordinates alone.
template <class F>
void with_joint(UncheckedTree tree, const double* q, int b, F&& f) {
  with_kernels(tree, b, [&](auto tag) {
    using K = typename decltype(tag)::type;
    double c[2], s[2];
    const auto angles = K::angles;
    for (std::size_t i = 0; i < angles.size(); ++i)
      sincos(q[tree.first_q(b) + angles[i]] + (K::rotates_about_z ? tree.link(b).angle_0 : 0.0), s[i], c[i]);
    f(tag, JointState<double>{q + tree.first_q(b), c, s});
  });
}

}  // namespace

void project_momentum(const Tree& tree, const double* q, const double* v, double* p) {
  ProjectionBuffers buffers;
  project_momentum(tree, q, v, p, buffers);
}

void project_momentum(const Tree& tree, const double* q, const double* v, double* p, ProjectionBuffers& buffers) {
  const auto n = static_cast<std::size_t>(tree.bodies());
  std::vector<Motion<double>>& velocity = buffers.velocity;
  std::vector<Force<double>>& momenta = buffers.momenta;
  std::vector<DenseTransform<double>>& transforms = buffers.transforms;
  if (velocity.size() < n) velocity.resize(n), momenta.resize(n), transforms.resize(n);
  for (int b : tree.order()) {
    const auto i = static_cast<std::size_t>(b);
    with_joint(tree, q, b, [&](auto tag, const JointState<double>& joint) {
      using K = typename decltype(tag)::type;
      transforms[i] = dense_transform<K, double>(tree.link(b), joint);
      Motion<double> m{};
      if (tree.parent(b) >= 0) m = velocity[static_cast<std::size_t>(tree.parent(b))];
      transforms[i].outboard(m);
      velocity[i] = K::template spatial_velocity<double>(tree.link(b), joint, m, v + tree.first_p(b));
      momenta[i] = momentum(tree.link(b).body, velocity[i]);  // (4)
    });
  }
  const auto order = tree.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k];
    const auto i = static_cast<std::size_t>(b);
    with_joint(tree, q, b, [&](auto tag, const JointState<double>& joint) {
      using K = typename decltype(tag)::type;
      const auto E = K::template columns<double>(tree.link(b), joint);
      const int at = tree.first_p(b);
      const LinkConstants& link = tree.link(b);
      for (std::size_t c = 0; c < E.size(); ++c) {
        const int f = at + static_cast<int>(c);
        if ((link.driven >> c & 1u) != 0)
          p[f] = v[f];  // the prescribed rate
        else
          p[f] = dot(E[c], momenta[i]) + tree.tables().armature[f] * v[f];
      }
    });
    if (tree.parent(b) >= 0) {
      transforms[i].inboard(momenta[i]);
      momenta[static_cast<std::size_t>(tree.parent(b))] += momenta[i];  // (14)
    }
  }
}

void add_momentum(const Tree& tree, const double* q, int b, const Motion<double>& parent, const double* v, double* p) noexcept {
  Force<double> P{};
  for (int a = static_cast<int>(tree.index(b)); a >= 0; a = tree.parent(a))
    with_joint(tree, q, a, [&](auto tag, const JointState<double>& joint) {
      using K = typename decltype(tag)::type;
      const DenseTransform<double> transform = dense_transform<K, double>(tree.link(a), joint);
      const int first = tree.first_p(a);
      if (a == b) {
        Motion<double> m = parent;
        transform.outboard(m);
        P = momentum(tree.link(a).body, K::template spatial_velocity<double>(tree.link(a), joint, m, v));  // (4), (17)
        for (int i = 0; i < info(tree.kind(a)).nv; ++i) p[first + i] = tree.tables().armature[first + i] * v[i];
      }
      absorb(tree, a, joint, P, +1, p);
      for (int i = 0; a == b && i < info(tree.kind(a)).nv; ++i)
        if ((tree.link(a).driven >> i & 1u) != 0) p[first + i] = v[i];
      transform.inboard(P);  // (29)
    });
}

State start_state(const Model& model, const Tree& tree, Variables variables) {
  MT_REQUIRE(model.size() == tree.bodies(), "the tree was compiled from this model");
  const auto declared = [&tree](const BodySpec& body, int b) {
    return tree.alive(b) && tree.joint_of(b) == b && tree.parent(b) == body.parent.index && tree.kind(b) == body.joint.kind;
  };
  State state(tree, variables);
  std::vector<double> v(static_cast<std::size_t>(tree.nv()));
  {
    const State::Edit edit = state.edit();
    for (int b = 0; b < tree.bodies(); ++b) {
      const BodySpec& s = model.bodies()[static_cast<std::size_t>(b)];
      MT_REQUIRE(declared(s, b), "the tree is as it was compiled from this model");
      const Values q = start_coordinates(s);
      std::copy(q.begin(), q.end(), edit.q.begin() + tree.first_q(b));
      for (int i = 0; i < s.v.size(); ++i) v[static_cast<std::size_t>(tree.first_p(b) + i)] = s.v[i];
    }
    follow_motions(tree, state.time(), edit.q.data(), v.data());
    if (variables == Variables::momenta)
      project_momentum(tree, state.q().data(), v.data(), edit.p.data());
    else
      std::copy(v.begin(), v.end(), edit.u.begin());
  }
  return state;
}

Force<double> articulated_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  return workspace.motions[tree.index(b)].articulated;
}

DenseTransform<double> locate_body(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  DenseTransform<double> pose{identity3<double>(), {}};
  const UncheckedTree all(tree);
  for (int a = static_cast<int>(tree.index(b)); a >= 0; a = all.parent(a))
    cross_inboard(all, state, workspace, a, [&](const auto& x) { x.place(pose.R, pose.r); });
  return pose;
}

void shed_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace, int b, Force<double> W, double sign,
                   double* p) noexcept {
  const UncheckedTree all(tree);
  for (int a = static_cast<int>(tree.index(b)), outer = all.parent(a); outer >= 0; a = outer, outer = all.parent(a)) {
    cross_inboard(all, state, workspace, a, [&](const auto& x) { x.inboard(W); });
    absorb(tree, outer, joint_state(all, state.q().data(), workspace, outer), W, sign, p);
  }
}

void absorb(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double sign, double* p) noexcept {
  const LinkConstants& link = tree.link(b);
  with_kernels(tree, b, [&](auto tag) {
    using K = typename decltype(tag)::type;
    const auto E = K::template columns<double>(link, joint);
    const unsigned locked = link.locked;
    double* own = p + UncheckedTree(tree).first_p(b);
    for (std::size_t i = 0; i < E.size(); ++i)
      if ((locked >> i & 1u) == 0) own[i] += sign * dot(E[i], W);
  });
}

int columns_of(const Tree& tree, int b, const JointState<double>& joint, Motion<double>* columns) noexcept {
  return with_kernels(tree, b, [&](auto tag) {
    const auto E = decltype(tag)::type::template columns<double>(tree.link(b), joint);
    std::copy(E.begin(), E.end(), columns);
    return static_cast<int>(E.size());
  });
}

void project(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double* p) noexcept {
  const LinkConstants& link = tree.link(b);
  with_kernels(tree, b, [&](auto tag) {
    using K = typename decltype(tag)::type;
    const auto E = K::template columns<double>(link, joint);
    for (std::size_t i = 0; i < E.size(); ++i) p[i] = dot(E[i], W);
  });
}

Force<double> to_user_frame(const KernelFrame& frame, const Force<double>& P) noexcept {
  Force<double> W{frame.R * P.l, frame.R * P.h};
  shift(W, frame.r);
  return W;
}

Force<double> to_kernel_frame(const KernelFrame& frame, const Force<double>& P) noexcept {
  return {transpose_times(frame.R, P.l), transpose_times(frame.R, P.h - cross(frame.r, P.l))};
}

}  // namespace momentree
