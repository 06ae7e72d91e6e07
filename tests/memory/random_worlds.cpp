#include <tests/memory/random_worlds.hpp>

#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <tests/oracle/random_model.hpp>
#include <tests/oracle/rearrange.hpp>

namespace momentree::memory {

namespace {

using oracle::Prng;

/// Rotations by 0, 90° and any angle, lengths that are zero or not; some with any placement.
Pose place_of_pin(Prng& random) {
  if (random.chance(0.2)) {
    const Vec3 r = random.vector(0.4);
    return {r, random.rotation()};
  }
  const double right = std::acos(0.0), alphas[] = {0, right, -right, 0.7};
  const double alpha = alphas[random.integer(0, 3)];
  const double a = random.chance(0.3) ? 0 : 0.3, d = random.chance(0.4) ? 0 : 0.2;
  return {{a, -d * std::sin(alpha), d * std::cos(alpha)}, from_axis_angle(x_axis, alpha)};
}

BodySpec any_body(Prng& random, int number, BodyId parent) {
  BodySpec body{.name = std::to_string(number), .mass = random.uniform(0.5, 2)};
  body.com = random.vector(0.2);
  body.inertia = diagonal(0.1, 0.08, 0.07);
  body.parent = parent;
  body.at = place_of_pin(random);
  return body;
}

struct Piece {
  int parent;  // among the limb's bodies; −1: the trunk
  int joint;
};
std::vector<Piece> random_limb(Prng& random) {
  std::vector<Piece> limb;
  const int bodies = random.integer(1, 7);
  const bool chain = random.chance(0.4);
  for (int k = 0; k < bodies; ++k) {
    const int parent = k == 0 || chain ? k - 1 : random.integer(0, k - 1);
    limb.push_back({parent, random.integer(0, 9)});
  }
  return limb;
}

JointSpec joint_of_limb(Prng& random, int sort) {
  if (sort == 0) return Weld{};
  if (sort == 1) return Prismatic{.axis = {0.2, 0.4, 1}, .armature = random.chance(0.5) ? 0.1 : 0.0};
  if (sort == 2 && random.chance(0.3)) return Revolute{.drive = motion_drive(Signal::sine(0.4, 2))};
  if (sort == 3 && random.chance(0.2))
    return Revolute{.limits = {.lower = -0.001, .upper = 0.001, .restitution = 0.5}, .strength = {.torque = 0.5}};
  if (sort < 5) return Revolute{.damping = 1, .armature = random.uniform(0.01, 0.1)};
  return Revolute{.damping = 1};
}

Model with_limbs(Prng& random) {
  Model model;
  const int trunk = random.integer(0, 3);
  for (int k = 0; k < trunk; ++k) {
    BodySpec body = any_body(random, k, k == 0 ? ground : BodyId{k - 1});
    body.joint = k == 0 && random.chance(0.6) ? JointSpec(Free{}) : JointSpec(Revolute{.damping = 1});
    model.add(body);
  }
  const std::vector<Piece> sorts[] = {random_limb(random), random_limb(random)};
  const int limbs = random.integer(2, 5);
  for (int k = 0; k < limbs; ++k) {
    const int first = model.size(), hangs = random.integer(0, 2);
    for (const Piece& piece : sorts[random.integer(0, 1)]) {
      const BodyId on_trunk = trunk == 0 ? ground : BodyId{hangs % trunk};
      BodySpec body = any_body(random, model.size(), piece.parent < 0 ? on_trunk : BodyId{first + piece.parent});
      body.joint = joint_of_limb(random, piece.joint);
      if (info(body.joint.kind).nv == 1 && body.joint.parameters.drive == nullptr) body.v = random.uniform(-2, 2);
      model.add(body);
    }
  }
  return model;
}

Model in_planes(Prng& random) {
  Model model;
  for (int m = random.integer(2, 4); m > 0; --m) {
    const bool flat = random.chance(0.6);
    const int first = model.size(), bodies = random.integer(1, 10);
    for (int k = 0; k < bodies; ++k) {
      BodySpec body = any_body(random, model.size(), k == 0 ? ground : BodyId{first + random.integer(k < 4 ? 0 : k - 4, k - 1)});
      if (flat && k > 0) body.at = {random.vector(0.4), from_axis_angle(z_axis, random.uniform(-1, 1))};
      body.joint = flat ? JointSpec(Revolute{.damping = 1}) : joint_of_limb(random, random.integer(0, 9));
      if (flat && k == 0 && random.integer(0, 2) == 0) body.joint = Planar{};
      model.add(body);
    }
  }
  return model;
}

Model of_all_kinds(std::uint64_t seed, Prng& random) {
  Model model = oracle::random_tree(seed, {.max_bodies = 25, .drives = true}).model;
  const int loads = random.integer(0, 2);
  for (int k = 0; k < loads; ++k)
    model.add_force({.body = {random.integer(0, model.size() - 1)},
                     .point = random.vector(0.1),
                     .force = {Signal::sine(1, 2), 0.5, 0.0},
                     .drag = {.linear = 0.1}});
  return model;
}

}  // namespace

Model random_model(std::uint64_t seed) {
  Prng random(seed);
  Model model = seed % 3 == 0 ? of_all_kinds(seed / 3, random) : seed % 3 == 1 ? with_limbs(random) : in_planes(random);
  model.set_gravity(seed % 2 == 0 ? Vec3{} : Vec3{0.3, -0.2, -9.81});
  return model;
}

Changed random_world(std::uint64_t seed) {
  const Model model = random_model(seed);
  Changed world{Tree(model), {}};
  world.state = start_state(model, world.tree);
  if (seed % 4 < 2) return world;
  Prng random(seed + 1000);
  Workspace<double> workspace(world.tree);
  oracle::rearrange(random, world.tree, world.state, workspace);
  return world;
}

void Seen::note(const Tree& tree) {
  for (const KernelRun& s : tree.tables().runs) {
    kernels[static_cast<int>(s.kind)][static_cast<int>(s.variant)] = true;
    planar += s.planar;
  }
  for (std::size_t i = 0; i < tree.order().size(); ++i) {
    const int b = tree.order()[i];
    branching += (tree.tables().node_flags[i] & node::branching) != 0;
    reversed += tree.reversed(b);
    locked += tree.link(b).locked != 0 && tree.link(b).driven == 0;
  }
  driven += static_cast<int>(tree.joints_with().motions.size());
  loaded += tree.loads().bodies.empty() ? 0 : 1;
  weightless += tree.gravity() == Vec3{};
}

std::string Seen::missing() const {
  std::string all;
  const auto want = [&](bool there, const char* what) {
    if (!there) all += std::string(all.empty() ? "" : ", ") + what;
  };
  int combinations = 0;
  for (const auto& kind : kernels)
    for (const bool variant : kind) combinations += variant ? 1 : 0;
  want(combinations >= 25, "kinds and variants");
  want(planar > 10, "planar mechanisms"), want(branching > 50, "branching bodies");
  want(reversed > 10, "reversed joints"), want(locked > 10, "locks"), want(driven > 10, "prescribed motions");
  want(loaded > 10, "forces on bodies"), want(weightless > 10, "worlds without gravity");
  return all;
}

}  // namespace momentree::memory
