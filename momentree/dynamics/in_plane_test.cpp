// Floating plane mechanisms against the spatial kernels, and what must not be taken for one: a free root's mechanism stays in a
// plane only if masses, gravity and momenta let it.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/topology/test_support.hpp>

namespace momentree {
namespace {

using namespace test;

/// A rotation that takes z to one of the six directions of the axes; its numbers are exact.
Mat3 turned_axes(int direction) {
  const double s = direction < 3 ? 1 : -1;
  if (direction % 3 == 0) return {0, 0, s, s, 0, 0, 0, 1, 0};
  if (direction % 3 == 1) return {0, s, 0, 0, 0, s, 1, 0, 0};
  return {s, 0, 0, 0, 1, 0, 0, 0, s};
}

/// The number of a root joint: revolute to the ground, planar, free.
enum Root { on_ground, on_plane, floating };

/// A tree of revolute joints in the plane whose normal is the third column of `axes`, in the axes of every body.
Model plane_tree(Random& random, Root root, const Mat3& axes) {
  Model model({.gravity = {}});
  const int bodies = 2 + random.below(12);
  const bool chain = random.chance(0.5);
  const Vec3 normal{axes.xz, axes.yz, axes.zz};
  const auto in_plane = [&](double size) { return axes * Vec3{random.between(-size, size), random.between(-size, size), 0}; };
  for (int k = 0; k < bodies; ++k) {
    BodySpec body{.name = "b/" + std::to_string(k), .mass = random.between(0.5, 2)};
    body.com = in_plane(0.2);
    body.inertia = rotate(axes, Sym3{random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1),
                                     random.between(-0.02, 0.02), 0, 0});
    body.parent = k == 0 ? ground : BodyId{chain ? k - 1 : random.below(k)};
    body.at = {in_plane(0.4), {}};
    body.joint = Revolute{.axis = normal};
    if (k == 0 && root != on_ground) body.joint = root == on_plane ? JointSpec(Planar{}) : JointSpec(Free{});
    if (k == 0) {
      const Vec3 e = random.vector(0.8);
      body.at = {random.vector(1), random.chance(0.3) ? Quat{} : normalized(Quat{1, e.x, e.y, e.z})};
    }
    model.add(body);
  }
  return model;
}

struct Moving {
  Tree tree;
  State state;
  Mat3 orientation;  ///< of a free root: plane's axes to world axes
};

/// Random coordinates, and momenta of random velocities in the plane.
Moving in_motion(const Model& model, Random& random, const Mat3& axes) {
  Moving world{compile(model), {}, axes};
  world.state = start_state(model, world.tree);
  std::vector<double> q(world.state.q().begin(), world.state.q().end()), v(world.state.p().size()), p(v.size());
  for (double& x : v) x = random.between(-2, 2);
  for (double& x : q) x = random.between(-3, 3);
  if (world.tree.kind(0) == Kind::free) {
    const Quat turn =
        normalized(Quat{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), random.between(0.1, 1)});
    q[3] = turn.w, q[4] = turn.x, q[5] = turn.y, q[6] = turn.z;
    world.orientation = rotation_matrix(model[{0}].at.rotation) * rotation_matrix(turn) * axes;
    const Vec3 l = axes * Vec3{v[0], v[1], 0}, h = axes * Vec3{0, 0, v[2]};
    v[0] = l.x, v[1] = l.y, v[2] = l.z, v[3] = h.x, v[4] = h.y, v[5] = h.z;
  }
  project_momentum(world.tree, q.data(), v.data(), p.data());
  const State::Edit edit = world.state.edit();
  std::copy(q.begin(), q.end(), edit.q.begin());
  std::copy(p.begin(), p.end(), edit.p.begin());
  return world;
}

bool is_plane(const Tree& tree, int root = 0) {
  for (const KernelRun& s : tree.kernel_runs())
    if (tree.order()[static_cast<std::size_t>(s.begin)] == root) return s.plane == s.begin && s.plane_end > s.begin + 1;
  return false;
}

/// Compares a stage with the spatial kernels; returns whether the stage was evaluated in the plane.
bool stage_in_plane(const Tree& tree, const State& state, int root = 0) {
  const auto q = state.q(), p = state.p();
  Workspace<double> stage(tree), spatial(tree);
  poison(tree, stage), poison(tree, spatial);
  evaluate_rates(tree, q.data(), p.data(), stage);
  evaluate_motions(tree, q.data(), p.data(), spatial);
  CHECK(difference(stage.v.get(), spatial.v.get(), tree.nv()) < 1e-12);
  CHECK(difference(stage.qdot.get(), spatial.qdot.get(), tree.nq()) < 1e-12);
  CHECK(difference(stage.pdot.get(), spatial.pdot.get(), tree.nv()) < 1e-12);
  for (const KernelRun& s : tree.kernel_runs())
    if (tree.order()[static_cast<std::size_t>(s.begin)] == root && s.plane == s.begin) return stage.in_plane[s.plane];
  return false;
}

/// Momenta and rates of momenta of the free root out of the plane.
double out_of_plane(const Mat3& axes, const double* p) {
  const Vec3 l = transpose_times(axes, Vec3{p[0], p[1], p[2]}), h = transpose_times(axes, Vec3{p[3], p[4], p[5]});
  return std::max({std::fabs(l.z), std::fabs(h.x), std::fabs(h.y)});
}

}  // namespace

TEST_CASE("floating plane mechanisms: the same rates as with the spatial kernels, whatever the plane") {
  for (unsigned seed = 0; seed < 3000; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Mat3 axes = turned_axes(static_cast<int>(seed % 6));
    Moving world = in_motion(plane_tree(random, floating, axes), random, axes);
    if (seed % 18 < 12) world.tree.set_gravity(world.orientation * Vec3{random.between(-5, 5), random.between(-9, 9), 0});
    CHECK(is_plane(world.tree));
    CHECK(out_of_plane(axes, world.state.p().data()) == 0);
    CHECK(stage_in_plane(world.tree, world.state));
    Workspace<double> motions(world.tree);  // by the spatial kernels; exactly in the plane, or later stages would not be
    evaluate_motions(world.tree, world.state.q().data(), world.state.p().data(), motions);
    CHECK(out_of_plane(axes, motions.pdot.get()) == 0);
  }
}

TEST_CASE("mechanisms on a planar joint: the same rates, whatever their masses and gravity") {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Mat3 axes = identity3<double>();
    const Model flat = plane_tree(random, on_plane, axes);
    Model model({.gravity = seed % 3 == 0 ? Vec3{} : random.vector(10)});
    for (int k = 0; k < flat.size(); ++k) {
      BodySpec body = flat[{k}];
      body.com.z = random.between(-0.2, 0.2), body.at.position.z = random.between(-0.2, 0.2);
      body.inertia.xz = random.between(-0.01, 0.01), body.inertia.yz = random.between(-0.01, 0.01);
      model.add(body);
    }
    const Moving world = in_motion(model, random, axes);
    CHECK(is_plane(world.tree));
    CHECK(stage_in_plane(world.tree, world.state));
  }
}

TEST_CASE("what is not quite plane is evaluated in space") {
  const Mat3 axes = identity3<double>();
  struct Change {
    const char* what;
    std::function<void(BodySpec&)> edit;
  };
  const Change changes[] = {
      {"a centre of mass", [](BodySpec& b) { b.com.z = 1e-14; }},
      {"a product of inertia", [](BodySpec& b) { b.inertia.xz = 1e-16; }},
      {"a product of inertia", [](BodySpec& b) { b.inertia.yz = -1e-16; }},
  };
  const Change of_joints[] = {
      {"a placement", [](BodySpec& b) { b.at.position.z = 1e-8; }},
      {"an axis",
       [](BodySpec& b) {
         b.joint = Revolute{.axis = {1e-8, 0, 1}};
       }},
      {"an opposite axis",
       [](BodySpec& b) {
         b.joint = Revolute{.axis = {0, 0, -1}};
       }},
      {"an armature", [](BodySpec& b) { b.joint = Revolute{.armature = 1e-3}; }},
      {"another kind",
       [](BodySpec& b) {
         b.joint = Prismatic{.axis = {1, 0, 0}};
       }},
  };
  for (unsigned seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Model flat = plane_tree(random, floating, axes);
    const int changed = random.below(flat.size());
    const auto with = [&](int at, const Change& change) {
      CAPTURE(std::string(change.what));
      Model model({.gravity = {1, -9.81, 0}});
      for (int k = 0; k < flat.size(); ++k) {
        BodySpec body = flat[{k}];
        if (k == at) change.edit(body);
        model.add(body);
      }
      const Moving world = in_motion(model, random, axes);
      // The only joint on a root may have either sense.
      const bool only = changed == 0 && at == 1 && std::string(change.what) == "an opposite axis" && model.size() == 2;
      if (!only) CHECK_FALSE(is_plane(world.tree));
      stage_in_plane(world.tree, world.state);
    };
    for (const Change& change : changes) with(changed, change);
    if (flat.size() > 2)
      for (const Change& change : of_joints) with(std::max(changed, 2), change);

    Moving world = in_motion(flat, random, axes);
    const Vec3 g = world.orientation * Vec3{1, -9.81, 0};
    world.tree.set_gravity(g);
    world.state = [&] {  // of this revision of the tree
      State state = start_state(flat, world.tree);
      const State::Edit edit = state.edit();
      std::copy(world.state.q().begin(), world.state.q().end(), edit.q.begin());
      std::copy(world.state.p().begin(), world.state.p().end(), edit.p.begin());
      return state;
    }();
    CHECK(stage_in_plane(world.tree, world.state));
    for (const int component : {2, 3, 4}) {
      State leaving = world.state;
      leaving.edit().p[static_cast<std::size_t>(component)] = random.chance(0.5) ? 1e-300 : 0.1;
      CHECK_FALSE(stage_in_plane(world.tree, leaving));
    }
    Tree tilted = world.tree;
    tilted.set_gravity(g + world.orientation * Vec3{0, 0, random.chance(0.5) ? 1e-9 : 3.0});
    CHECK_FALSE(stage_in_plane(tilted, world.state));
  }
}

TEST_CASE("what breaks off a plane mechanism stays in its plane, with its energy and momenta") {
  int pieces = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Mat3 axes = turned_axes(static_cast<int>(seed % 6));
    const Model model = plane_tree(random, on_ground, axes);
    Moving world = in_motion(model, random, axes);
    Tree& tree = world.tree;
    State& state = world.state;
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    std::vector<int> roots;
    for (int b = 1; b < tree.bodies(); ++b) {
      if (tree.first_child(b) < 0 || random.chance(0.7)) continue;
      const Totals before = totals(tree, state, workspace);
      apply(Break{tree.inboard_joint(BodyId{b})}, tree, state, workspace);
      forward_dynamics(tree, state, workspace);
      const Totals after = totals(tree, state, workspace);
      CHECK(after.kinetic == doctest::Approx(before.kinetic).epsilon(1e-12));
      CHECK(norm(after.angular - before.angular) < 1e-11);
      roots.push_back(b);
    }
    std::erase_if(roots, [&](int root) { return tree.first_child(root) < 0; });
    for (const int root : roots) {
      CHECK(is_plane(tree, root));
      CHECK(stage_in_plane(tree, state, root));
      CHECK(out_of_plane(axes, state.p().data() + tree.first_p(root)) == 0);
    }
    pieces += static_cast<int>(roots.size());
    // Without gravity the mechanisms that float keep their momenta and all keep their energy.
    Evaluator evaluate(tree, workspace);
    EnergyLedger ledger;
    const auto integrator = make_integrator("rk4", tree, {.step = 1e-4});
    const Totals before = totals(tree, state, workspace);
    for (int i = 0; i < 50; ++i) {
      evaluate(state);
      CHECK(integrator->step(evaluate, state, ledger, 1e-4));
    }
    evaluate(state);
    CHECK(totals(tree, state, workspace).kinetic == doctest::Approx(before.kinetic).epsilon(1e-9));
    for (const int root : roots) CHECK(stage_in_plane(tree, state, root));
  }
  CHECK(pieces > 200);
}

}  // namespace momentree
