#include <momentree/dynamics/tangent/memory.hpp>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/forces/joint_spring.hpp>
#include <momentree/dynamics/forces/load_laws.hpp>
#include <momentree/dynamics/forces/resistance.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>

namespace momentree {

using namespace detail::tangents;

NotDifferentiable not_differentiable(const Tree& tree, const Workspace<double>& workspace) noexcept {
  using Part = NotDifferentiable::Part;
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    if (tree.loops()[i].forced() || tree.loops().links[i].dof_row_count > 0) return {Part::loop_joint, static_cast<int>(i)};
  const ContactWorkspace* const contacts = workspace.contacts.get();
  if (!tree.contacts().empty() || (contacts != nullptr && !(contacts->held.empty() && contacts->stops.empty())))
    return {Part::contact, 0};
  for (const int b : tree.joints_with().forces)
    if (tree.function(b) != nullptr) return {Part::joint_function, b};
  for (const Topology::Loaded& load : tree.loads().functions)
    if (tree.alive(load.body)) return {Part::body_function, load.body};
  return {};
}

namespace {

void store(const std::vector<Lanes>& from, int nv, int first, int used, double* to) {
  for (int i = 0; i < nv; ++i)
    for (int k = 0; k < used; ++k) to[at(first + k) * at(nv) + at(i)] = from[at(i)][k];
}

}  // namespace

AccelerationTangent::AccelerationTangent(const Tree& tree) : memory_(std::make_unique<Memory>(tree)) {}
AccelerationTangent::AccelerationTangent(AccelerationTangent&&) noexcept = default;
AccelerationTangent& AccelerationTangent::operator=(AccelerationTangent&&) noexcept = default;
AccelerationTangent::~AccelerationTangent() = default;

void AccelerationTangent::prepare(const Tree& tree, const State& state, Workspace<double>& workspace) {
  Memory& m = *memory_;
  MT_REQUIRE(m.bodies.size() >= at(tree.bodies()), "the tangent has room for the tree's bodies: construct it for this tree");
  momentree::accelerate(tree, state, workspace);
  m.needs_places = !tree.loads().bodies.empty() || tree.has_loops();
  if (m.needs_places) locate_bodies(tree, state, workspace);
  m.tree = &tree, m.state = &state, m.workspace = &workspace;
  resisting_forces(tree, state.time(), state.q().data(), workspace.v.get(),
                   {m.resisting.data(), m.resisting.data(), m.slope.data(), m.stiffness.data()});
  for (int i = 0; i < tree.nv(); ++i) m.slope[at(i)] += tree.tables().damping[i];
  for (const int b : tree.order()) {
    m.transmitted[at(b)] = transmitted_wrench(tree, workspace, b);
    m.with_kernels(b, [&](auto tag, const LinkConstants&) {
      using K = typename decltype(tag)::type;
      const auto* const from = reinterpret_cast<const double*>(&workspace.record<K>(tree, b));
      auto* const to = reinterpret_cast<Lanes*>(&m.record<K>(b));
      for (std::size_t i = 0; i < sizeof(typename K::template Record<double>) / sizeof(double); ++i) to[i] = Lanes(from[i]);
    });
  }
  m.rows.clear();
  if (tree.has_loops()) m.prepare_loops(workspace);
}

void AccelerationTangent::along(int count, const double* dq, const double* dv, double* da) noexcept {
  Memory& m = *memory_;
  MT_REQUIRE(m.workspace != nullptr && accelerated_on(*m.tree, *m.state, *m.workspace),
             "prepare was called for the present state");
  for (int first = 0; first < count; first += Lanes::lanes) {
    const int used = m.load(first, count, dq, dv);
    m.outward();
    if (!m.tree->loads().bodies.empty()) m.add_loads();
    if (m.tree->has_loops()) m.add_loop_wrenches();
    m.inward();
    m.accelerate();
    if (m.tree->has_loops()) m.close_accelerations();
    store(m.da, m.tree->nv(), first, used, da);
  }
}

void AccelerationTangent::allow(int count, double* dq, double* dv) noexcept {
  Memory& m = *memory_;
  for (int first = 0; first < count; first += Lanes::lanes) {
    const int used = m.load(first, count, dq, dv);
    if (m.tree->has_loops()) m.close_direction();
    store(m.dq, m.tree->nv(), first, used, dq), store(m.dv, m.tree->nv(), first, used, dv);
  }
}

int AccelerationTangent::Memory::load(int first, int count, const double* q_directions, const double* v_directions) noexcept {
  const int nv = tree->nv(), used = std::min(count - first, Lanes::lanes);
  const auto put = [&](const double* from, std::vector<Lanes>& to) {
    for (int i = 0; i < nv; ++i) {
      to[at(i)] = Lanes(0.0);
      for (int k = 0; from != nullptr && k < used; ++k) to[at(i)].set(k, from[at(first + k) * at(nv) + at(i)]);
    }
  };
  put(q_directions, dq), put(v_directions, dv);
  for (const int b : tree->order())
    for (int i = 0; i < info(tree->kind(b)).nv; ++i)
      if ((tree->link(b).locked >> i & 1u) != 0) dq[at(tree->first_p(b) + i)] = dv[at(tree->first_p(b) + i)] = Lanes(0.0);
  return used;
}

bool AccelerationTangent::Memory::moves(int b) const noexcept {
  typename Lanes::Mask zero = ~typename Lanes::Mask{};
  for (int i = tree->first_p(b), end = i + info(tree->kind(b)).nv; i < end; ++i)
    zero &= within(dq[at(i)], 0) & within(dv[at(i)], 0);
  for (int k = 0; k < Lanes::lanes; ++k)
    if (zero[k] == 0) return true;
  return false;
}

void AccelerationTangent::Memory::outward() noexcept {
  const double* const all_q = state->q().data();
  for (const int b : tree->order()) {
    BodyTangent& own = bodies[at(b)];
    const int outer = tree->parent(b), first = tree->first_p(b);
    own = {};
    const bool carried_along = outer >= 0 && bodies[at(outer)].moves;
    own.moves = carried_along || moves(b);
    if (!own.moves) {  // a third of the bodies of a chain, for all its directions
      std::fill_n(da.begin() + first, info(tree->kind(b)).nv, Lanes(0.0));
      continue;
    }
    if (carried_along) own.place = bodies[at(outer)].place, own.velocity = bodies[at(outer)].velocity;
    const Motion<double>& velocity = workspace->motions[at(b)].velocity;
    with_kernels(b, [&](auto tag, const LinkConstants& link) {
      using K = typename decltype(tag)::type;
      const double *const u = workspace->v.get() + first, *const udot = workspace->a.get() + first;
      const Lanes* const step = dq.data() + first;
      const JointState<double> joint = joint_state(*tree, all_q, *workspace, b);
      const SpreadJoint spread_q = spread_joint<K>(joint);
      const auto& transform = K::template cached_transform<false, Lanes>(link, spread_q.state(), record<K>(b));
      const JointTangent<K> own_joint(link, joint, u, udot, step, dv.data() + first);
      const Force<Lanes> Tr = spread(transmitted[at(b)]);
      for (std::size_t i = 0; i < own_joint.E.size(); ++i) {
        const bool held = (link.locked >> i & 1u) != 0;
        da[at(first) + i] =
            held ? Lanes(0.0)
                 : -own_joint.turned(i, Tr) - slope[at(first) + i] * dv[at(first) + i] - stiffness[at(first) + i] * step[i];
      }
      own.displacement = own_joint.displacement;
      transform.outboard(own.velocity);
      if (needs_places) transform.outboard(own.place), own.place = own.place + own.displacement;
      const auto carried = [&](const Motion<double>& a) {  // −η × a
        const Motion<Lanes> turned = cross(own.displacement, spread(a));
        return Motion<Lanes>{-turned.v, -turned.w};
      };
      const Motion<double>& through = own_joint.velocity;
      own.velocity = own.velocity + carried({velocity.v - through.v, velocity.w - through.w}) + own_joint.velocity_rate;
      const BiasTangent bias = own_joint.bias(link, velocity, own.velocity);
      const Motion<double>& inboard = workspace->inboard_accelerations[at(b)];
      own.acceleration = carried({inboard.v - bias.value.v, inboard.w - bias.value.w}) + bias.rate + own_joint.turning;
      if (const JointParameters* const p = tree->parameters(b); p != nullptr && p->stiffness.any()) {
        Number spring[6];
        const MovingJoint moving = moving_joint<K>(joint, u, step, dv.data() + first);
        joint_spring_at(*tree, moving.q.data(), b, spring);
        for (std::size_t i = 0; i < own_joint.E.size(); ++i)
          if ((link.locked >> i & 1u) == 0) da[at(first) + i] = da[at(first) + i] + spring[i].e;
      }
    });
    const RigidMass& body = tree->link(b).body;
    own.wrench = cross(own.velocity, spread(momentum(body, velocity))) + cross(spread(velocity), momentum(body, own.velocity));
  }
}

Kinematics<Number> AccelerationTangent::Memory::located(int b) const noexcept {
  const Kinematics<double>& body = workspace->bodies[at(b)];
  const BodyTangent& own = bodies[at(b)];
  const Matrix3<Lanes> turn{Lanes(0.0),     -own.place.w.z, own.place.w.y, own.place.w.z, Lanes(0.0),
                            -own.place.w.x, -own.place.w.y, own.place.w.x, Lanes(0.0)};
  const auto dense = [](const Mat3& R) {
    return Matrix3<Lanes>{Lanes(R.xx), Lanes(R.xy), Lanes(R.xz), Lanes(R.yx), Lanes(R.yy),
                          Lanes(R.yz), Lanes(R.zx), Lanes(R.zy), Lanes(R.zz)};
  };
  const Matrix3<Lanes> dR = dense(body.R) * turn;
  const Mat3& R = body.R;
  return {{{R.xx, dR.xx},
           {R.xy, dR.xy},
           {R.xz, dR.xz},
           {R.yx, dR.yx},
           {R.yy, dR.yy},
           {R.yz, dR.yz},
           {R.zx, dR.zx},
           {R.zy, dR.zy},
           {R.zz, dR.zz}},
          with_rate(body.r, body.R * own.place.v),
          with_rate(body.velocity, own.velocity)};
}

void AccelerationTangent::Memory::add_loads() noexcept {
  const auto take = [&](int b, const Force<Number>& load) { bodies[at(b)].wrench = bodies[at(b)].wrench - rate_of(load); };
  for (const BodyForce& force : tree->loads().forces) {
    const int b = force.body.index;
    if (!tree->alive(b)) continue;
    forces::PowerOf<Number> power;
    take(b, forces::wrench_of(force, tree->frame(b), located(b), state->time(), power));
  }
  for (int i = 0; i < tree->springs().count(); ++i) {
    if (!spring_acts(*tree, i)) continue;
    const Spring& spring = tree->springs()[at(i)];
    Kinematics<Number> ends[2];
    const auto end = [&](const SpringEnd& e, Kinematics<Number>& body) {
      if (e.body == ground) return forces::spring_point<Number>(e, nullptr, nullptr);
      body = located(e.body.index);
      return forces::spring_point(e, &tree->frame(e.body.index), &body);
    };
    const forces::SpringPoint<Number> from = end(spring.from, ends[0]), to = end(spring.to, ends[1]);
    const forces::SpringStretch<Number> stretch(from, to);
    if (!(stretch.length.r > 0)) continue;
    const Vector3<Number> pull = forces::tension_of(tree->springs().law(i), stretch.length, stretch.rate) * stretch.direction;
    if (from.body != nullptr) take(spring.from.body.index, forces::pull(from, pull));
    if (to.body != nullptr) take(spring.to.body.index, forces::pull(to, -pull));
  }
}

void AccelerationTangent::Memory::inward() noexcept {
  const double* const q = state->q().data();
  const auto order = tree->order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k], outer = tree->parent(b);
    BodyTangent& own = bodies[at(b)];
    Force<Lanes> W = own.wrench;
    with_kernels(b, [&](auto tag, const LinkConstants& link) {
      using K = typename decltype(tag)::type;
      const SpreadJoint joint = spread_joint<K>(joint_state(*tree, q, *workspace, b));
      Lanes* const force = da.data() + tree->first_p(b);
      K::template reduce_wrench<Lanes>(link, joint.state(), record<K>(b), force, W, force);  // (51)
      if (own.moves) {
        K::add_reduced_bias(record<K>(b), own.acceleration, W);
        W += cross(own.displacement, spread(transmitted[at(b)]));
      }
      K::template cached_transform<false, Lanes>(link, joint.state(), record<K>(b)).inboard(W);  // (45)
    });
    if (outer >= 0) bodies[at(outer)].wrench += W;
  }
}

void AccelerationTangent::Memory::accelerate() noexcept {
  const double* const q = state->q().data();
  for (const int b : tree->order()) {
    const int outer = tree->parent(b);
    BodyTangent& own = bodies[at(b)];
    Motion<Lanes> a{};
    if (outer >= 0) a = bodies[at(outer)].acceleration;
    with_kernels(b, [&](auto tag, const LinkConstants& link) {
      using K = typename decltype(tag)::type;
      const SpreadJoint joint = spread_joint<K>(joint_state(*tree, q, *workspace, b));
      K::template cached_transform<false, Lanes>(link, joint.state(), record<K>(b)).outboard(a);
      a = K::template accelerate<Lanes>(link, joint.state(), record<K>(b), a + own.acceleration,
                                        da.data() + tree->first_p(b));  // (47)
    });
    own.acceleration = a;
  }
}

void displacement_rates(const Tree& tree, const double* v, const double* dq, const double* dv, double* rate) noexcept {
  std::copy_n(dv, tree.nv(), rate);
  for (const int b : tree.order()) {
    const KindInfo& kind = info(tree.kind(b));
    const int first = tree.first_p(b);
    if (kind.nq == kind.nv) continue;
    const auto motion = [&](const double* x) -> Motion<double> {  // of a ball or a free joint
      x += first;
      if (kind.nv == 3) return {{}, {x[0], x[1], x[2]}};
      return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    };
    const Motion<double> turned = cross(motion(v), motion(dq));
    const double six[] = {turned.v.x, turned.v.y, turned.v.z, turned.w.x, turned.w.y, turned.w.z};
    for (int i = 0; i < kind.nv; ++i)
      if ((tree.link(b).locked >> i & 1u) == 0) rate[first + i] -= six[6 - kind.nv + i];
  }
}

void displace(const Tree& tree, const double* dq, double* q) noexcept { detail::displace(tree, dq, 1, q); }

}  // namespace momentree
