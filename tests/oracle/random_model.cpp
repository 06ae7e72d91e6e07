#include <tests/oracle/random_model.hpp>

#include <algorithm>
#include <string>
#include <string_view>

#include <momentree/base/check.hpp>

namespace momentree::oracle {
namespace {

int coordinates_of(Kind kind) { return info(kind).nq; }
int dofs_of(Kind kind) { return info(kind).nv; }

Values positive_values(Prng& random, int count, double low, double high) {
  Values values;
  for (int i = 0; i < count; ++i) {
    const double value = random.log_uniform(low, high);
    values.push_back(value);
  }
  return values;
}

/// A moment of inertia that a cloud of point masses can have: from positive second moments along random axes.
Sym3 random_inertia(Prng& random, double mass) {
  const double size = random.log_uniform(0.05, 0.5);
  const double a = random.uniform(0.1, 1) * mass * size * size;
  const double b = random.uniform(0.1, 1) * mass * size * size;
  const double c = random.uniform(0.1, 1) * mass * size * size;
  const Quat axes = random.rotation();
  return rotate(rotation_matrix(axes), diagonal(b + c, a + c, a + b));
}

Pose random_pose(Prng& random, double size) {
  const Vec3 position = random.vector(size);
  const Quat rotation = random.rotation();
  return {position, rotation};
}

void draw_parameters(Prng& random, JointSpec& joint, const RandomTreeOptions& options) {
  const int nv = dofs_of(joint.kind);
  if (nv == 0) return;
  JointParameters& p = joint.parameters;
  if (random.chance(0.3)) p.armature = positive_values(random, nv, 1e-3, 1);
  if (random.chance(0.3)) {
    p.stiffness = positive_values(random, nv, 0.1, 10);
    if (random.chance(0.5)) p.rest = random_coordinates(random, joint.kind);
  }
  if (options.conservative) return;
  if (random.chance(0.3)) p.damping = positive_values(random, random.chance(0.5) ? 1 : nv, 1e-2, 1);
  if (random.chance(0.3)) p.effort = random_velocities(random, joint.kind);
}

Signal random_signal(Prng& random) {
  const int what = random.integer(0, 2);
  if (what == 0) return {random.uniform(-1, 1)};
  if (what == 1) {
    const double amplitude = random.uniform(-1, 1), frequency = random.uniform(0.1, 2), phase = random.uniform(-3, 3);
    return Signal::sine(amplitude, frequency, phase, random.uniform(-1, 1));
  }
  std::vector<Signal::Knot> knots;
  double t = random.uniform(-0.5, 0.2);
  for (int k = random.integer(2, 5); k > 0; --k) {
    knots.push_back({t, random.uniform(-1, 1)});
    t += random.uniform(0.1, 0.5);
  }
  return Signal::table(knots);
}

std::vector<Signal> random_signals(Prng& random, int count) {
  std::vector<Signal> signals;
  for (int i = 0; i < count; ++i) signals.push_back(random_signal(random));
  return signals;
}

void draw_drives(Prng& random, JointSpec& joint) {
  const int nv = dofs_of(joint.kind);
  if (nv == 0) return;
  JointParameters& p = joint.parameters;
  const auto some = [&] { return random.chance(0.5) ? 1 : nv; };
  if (random.chance(0.4)) {
    p.friction.coulomb = positive_values(random, some(), 0.1, 2);
    p.friction.speed = positive_values(random, some(), 0.01, 2);
  }
  const bool rates = coordinates_of(joint.kind) == nv;
  if (rates && random.chance(0.4)) {  // half of all states are beyond a soft stop
    p.limits.lower = -random.uniform(0, 0.3);
    p.limits.upper = random.uniform(0.01, 0.3);
    p.limits.stiffness = positive_values(random, some(), 0.1, 10);
    if (random.chance(0.5)) p.limits.damping = positive_values(random, some(), 0.1, 10);
  }
  JointDrive drive;
  if (random.chance(0.4)) drive.effort = random_signals(random, nv);
  if (rates && random.chance(0.4)) {
    drive.pd.kp = positive_values(random, some(), 0.1, 10);
    drive.pd.kd = positive_values(random, some(), 0.1, 10);
    if (random.chance(0.7)) drive.pd.target = random_signals(random, some());
    if (random.chance(0.3)) drive.pd.target_speed = random_signals(random, some());
    if (random.chance(0.5)) drive.pd.max_effort = positive_values(random, some(), 0.1, 10);
  }
  if (random.chance(0.9)) p.drive = std::make_shared<const JointDrive>(drive);
}

int draw_parent(Prng& random, Shape shape, int k) {
  if (k == 0) return -1;
  switch (shape) {
    case Shape::chain: return k - 1;
    case Shape::bushy: {
      const double u = random.unit();
      return static_cast<int>(k * u * u);
    }
    case Shape::mixed: return random.integer(k < 3 ? 0 : k - 3, k - 1);
  }
  return k - 1;
}

Kind draw_root_kind(Prng& random, Root root) {
  if (root == Root::welded) return Kind::weld;
  if (root == Root::free) return Kind::free;
  const int moving = static_cast<int>(every_kind().size()) - 2;  // the last two are free and weld
  return every_kind()[static_cast<std::size_t>(random.integer(0, moving - 1))];
}

}  // namespace

const std::vector<Kind>& every_kind() {
  static const std::vector<Kind> kinds = [] {
    // Seeds draw these kinds in this order; kinds that are added later follow the other moving ones.
    std::vector<Kind> all{Kind::revolute,  Kind::prismatic, Kind::helical, Kind::cylindrical,
                          Kind::universal, Kind::ball,      Kind::planar};
    for (const KindInfo& each : all_kinds())
      if (each.kind != Kind::free && each.kind != Kind::weld && std::find(all.begin(), all.end(), each.kind) == all.end())
        all.push_back(each.kind);
    all.push_back(Kind::free);
    all.push_back(Kind::weld);
    return all;
  }();
  return kinds;
}

Kind random_kind(Prng& random) {
  return every_kind()[static_cast<std::size_t>(random.integer(0, static_cast<int>(every_kind().size()) - 1))];
}

JointSpec random_joint(Prng& random, Kind kind, const RandomTreeOptions& options) {
  JointSpec joint;
  joint.kind = kind;
  joint.axis = random.direction();
  if (info(kind).axis2) {
    joint.axis2 = random.direction();
    while (std::abs(dot(joint.axis, joint.axis2)) > 0.8) joint.axis2 = random.direction();
  }
  if (info(kind).pitch) {
    joint.pitch = random.uniform(0.05, 0.5);
    if (random.chance(0.5)) joint.pitch = -joint.pitch;
  }
  if (!info(kind).axis) joint.axis = {0, 0, 1};
  if (options.parameters) draw_parameters(random, joint, options);
  if (options.drives) draw_drives(random, joint);
  return joint;
}

Values random_coordinates(Prng& random, Kind kind) {
  Values q;
  for (const char unit : std::string_view(info(kind).q_units)) {
    if (unit == 'n') break;  // the components of a quaternion, which are the last coordinates
    const double value = unit == 'm' ? random.uniform(-0.5, 0.5) : random.uniform(-3, 3);
    q.push_back(value);
  }
  if (std::string_view(info(kind).q_units).ends_with('n')) {
    const Quat rotation = random.rotation();
    for (double component : {rotation.w, rotation.x, rotation.y, rotation.z}) q.push_back(component);
  }
  return q;
}

Values random_velocities(Prng& random, Kind kind) {
  Values v;
  for (int i = 0; i < dofs_of(kind); ++i) {
    const double value = random.uniform(-1, 1);
    v.push_back(value);
  }
  return v;
}

RandomTree random_tree(std::uint64_t seed, const RandomTreeOptions& options) {
  Prng random(seed);
  RandomTree tree;
  tree.shape = static_cast<Shape>(seed % 3);
  tree.root = options.all_free ? Root::free : static_cast<Root>(seed / 3 % 3);
  if (options.gravity)
    tree.model.set_gravity(random.vector(10));
  else
    tree.model.set_gravity({0, 0, 0});
  const int bodies = random.integer(options.min_bodies, options.max_bodies);
  const bool several = options.several_mechanisms && random.chance(0.2);

  int first = 0;  // first body of the present mechanism
  int mechanism = 0;
  for (int k = 0; k < bodies; ++k) {
    if (several && k > first && random.chance(3.0 / bodies)) {
      first = k;
      ++mechanism;
    }
    const int parent = draw_parent(random, tree.shape, k - first);
    Root root = tree.root;
    if (mechanism > 0 && !options.all_free) root = static_cast<Root>(random.integer(0, 2));
    Kind kind = draw_root_kind(random, root);
    if (parent >= 0 && options.kinds.empty()) kind = random_kind(random);
    if ((parent >= 0 || root == Root::jointed) && !options.kinds.empty())
      kind = options.kinds[static_cast<std::size_t>(random.integer(0, static_cast<int>(options.kinds.size()) - 1))];

    BodySpec body;
    body.name = "m" + std::to_string(mechanism) + "/b" + std::to_string(k);
    body.mass = random.log_uniform(1e-2, 1e2);
    body.com = random.vector(0.3);
    body.inertia = random_inertia(random, body.mass);
    body.parent = parent < 0 ? ground : BodyId{first + parent};
    body.at = random_pose(random, 0.5);
    if (random.chance(0.5)) body.child_at = random_pose(random, 0.2);
    body.joint = random_joint(random, kind, options);
    body.q = random_coordinates(random, kind);
    body.v = random_velocities(random, kind);
    tree.model.add(body);
  }
  return tree;
}

int dofs(const Model& model) {
  int count = 0;
  for (const BodySpec& body : model.bodies()) count += dofs_of(body.joint.kind);
  return count;
}

}  // namespace momentree::oracle
