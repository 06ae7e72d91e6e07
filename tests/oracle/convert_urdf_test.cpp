// URDF written by `momentree convert` moves identically: random trees of all joint kinds except helical, and the models of this
// repository, at random states; compared by the accelerations of centres of mass and of bodies.
#include <string>
#include <unordered_map>

#include <doctest/doctest.h>

#include <momentree/models/import/imported.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/world/world.hpp>
#include <tests/oracle/oracle.hpp>
#include <tests/oracle/same_dynamics.hpp>

namespace momentree::oracle {
namespace {

std::string bare(const std::string& name) { return name.substr(name.find('/') + 1); }

struct Start {
  Values q, v;
};

/// A random state of a joint, and the corresponding states of the joints that replace it in the URDF, by name.
Start draw(const BodySpec& spec, Prng& random, std::unordered_map<std::string, Start>& written) {
  const std::string name = bare(spec.joint_name);
  Start start{random_coordinates(random, spec.joint.kind), random_velocities(random, spec.joint.kind)};
  if (spec.joint.kind == Kind::ball) {
    const double a = random.uniform(-3, 3), b = random.uniform(-1, 1), c = random.uniform(-3, 3);
    const Quat x = from_axis_angle(x_axis, a), y = from_axis_angle(y_axis, b), z = from_axis_angle(z_axis, c);
    const Quat r = normalized(x * y * z);
    start.q = {r.w, r.x, r.y, r.z};
    const Values& rates = start.v;
    const Mat3 to_z = rotation_matrix(conjugate(z)), to_yz = rotation_matrix(conjugate(y * z));
    const Vec3 w = rates[0] * (to_yz * x_axis) + rates[1] * (to_z * y_axis) + rates[2] * z_axis;
    written[name + ".x"] = {a, rates[0]}, written[name + ".y"] = {b, rates[1]}, written[name + ".z"] = {c, rates[2]};
    start.v = {w.x, w.y, w.z};
  } else if (spec.joint.kind == Kind::universal || spec.joint.kind == Kind::cylindrical) {
    const bool universal = spec.joint.kind == Kind::universal;
    written[name + (universal ? ".1" : ".angle")] = {start.q[0], start.v[0]};
    written[name + (universal ? ".2" : ".displacement")] = {start.q[1], start.v[1]};
  } else {
    written[name] = start;
  }
  return start;
}

struct Accelerations {
  std::unordered_map<std::string, std::pair<Vec3, Vec3>> of;  ///< of the centre of mass, and angular, by bare names
  double largest = 0;
};
Accelerations accelerations(const Model& model) {
  const World world(model);
  Accelerations all;
  for (int number = 0; number < model.size(); ++number) {
    const auto k = static_cast<std::size_t>(number);
    const BodyAcceleration& a = world.accelerations()[k];
    const BodyMotion& m = world.motions()[k];
    const Vec3 arm = rotation_matrix(m.pose.rotation) * model[BodyId{number}].com;
    const Vec3 com = a.linear + cross(a.angular, arm) + cross(m.angular, cross(m.angular, arm));
    const bool massless = model[BodyId{number}].mass == 0;  // its frame may be moved, and it has no centre of mass
    all.of[bare(model[BodyId{number}].name)] = {massless ? Vec3{} : com, a.angular};
    all.largest = std::max({all.largest, norm(com), norm(a.angular)});
  }
  return all;
}

/// Largest difference of accelerations relative to the largest acceleration, at one random state.
double compare(const Model& model, const Model& written, Prng& random, double& bound) {
  std::unordered_map<std::string, Start> starts;
  Model here({.gravity = model.gravity()}), there({.gravity = model.gravity()});
  for (const BodySpec& each : model.bodies()) {
    BodySpec spec = each;
    const Start start = draw(each, random, starts);
    spec.q = start.q, spec.v = start.v;
    here.add_unjudged(spec);
    if (spec.parent == ground && spec.joint.kind == Kind::free) starts.try_emplace(bare(spec.name), start);
  }
  for (const BodySpec& each : written.bodies()) {
    BodySpec spec = each;
    if (spec.joint.kind != Kind::weld) {
      REQUIRE_MESSAGE(starts.contains(bare(spec.joint_name)), spec.joint_name);
      spec.q = starts[bare(spec.joint_name)].q, spec.v = starts[bare(spec.joint_name)].v;
    }
    there.add_unjudged(spec);
  }
  // The accelerations of either model have a rounding that the condition of its mass matrix amplifies.
  const auto condition = [](const Model& of) { return spectrum(mass_matrix(system_of(of), start_q(of))).condition(); };
  bound = std::max(1e-12, 1e-15 * (condition(here) + condition(there)));
  const Accelerations a = accelerations(here), b = accelerations(there);
  double worst = 0;
  for (const auto& [name, pair] : a.of) {
    REQUIRE_MESSAGE(b.of.contains(name), name);
    worst = std::max({worst, norm(pair.first - b.of.at(name).first), norm(pair.second - b.of.at(name).second)});
  }
  return worst == 0 ? 0 : worst / a.largest;  // trees of welds do not move
}

io::Scenario read(const std::string& text, const std::string& name, const std::vector<std::string>& overrides) {
  const io::ReadResult result = io::read_scenario_text(text, name, overrides);
  CAPTURE(text.substr(0, 3000));
  CAPTURE(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return *result.scenario;
}

bool is_free(const io::Converted& converted) {
  for (const io::Diagnostic& each : converted.diagnostics)
    if (each.hint.find("root = \"free\"") != std::string::npos) return true;
  return false;
}

/// The joint parameters that URDF supports: damping and friction, one number for each of its joints.
void draw_resistance(Prng& random, JointSpec& joint) {
  const int nv = info(joint.kind).nv;
  if (nv == 0 || joint.kind == Kind::ball) return;
  const bool chain = joint.kind == Kind::universal || joint.kind == Kind::cylindrical;
  const auto some = [&] {
    Values all = random.log_uniform(1e-2, 1);
    while (chain && all.size() < nv) all.push_back(random.log_uniform(1e-2, 1));
    return all;
  };
  if (random.chance(0.5)) joint.parameters.damping = some();
  if (random.chance(0.3)) joint.parameters.friction = {some(), io::imported_friction_speed};
}

}  // namespace

TEST_CASE("2,000 random trees, as URDF and back") {
  double worst = 0, ratio = 0;
  int roots = 0, chains = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.max_bodies = 10;
    options.several_mechanisms = false;
    options.parameters = false;
    options.kinds = {Kind::revolute, Kind::prismatic, Kind::cylindrical, Kind::universal,
                     Kind::ball,     Kind::planar,    Kind::free,        Kind::weld};
    const Model drawn = random_tree(seed, options).model;
    Prng random(seed + 7);
    Model model({.gravity = drawn.gravity()});
    for (BodySpec spec : drawn.bodies()) {
      draw_resistance(random, spec.joint);
      if (spec.parent == ground && random.chance(0.5)) {  // a root that needs no joint
        spec.at = {};
        if (spec.joint.kind == Kind::free) spec.joint.parameters = {};
      }
      if (random.chance(0.3)) spec.child_at.position = {};
      model.add(spec);
    }
    const io::Scenario scenario = read(io::to_toml(model), "s.toml", {});
    const io::Converted converted = io::to_urdf(scenario, "", "");
    const bool free = is_free(converted);
    roots += free;
    for (const io::Diagnostic& each : converted.diagnostics) chains += each.what.find("written as chains") != std::string::npos;
    io::Scenario again =
        read(converted.text, "r.urdf", free ? std::vector<std::string>{"mechanism.r.root=free"} : std::vector<std::string>{});
    again.model.set_gravity(model.gravity());  // a URDF has no gravity
    double bound = 0;
    const double apart = compare(model, again.model, random, bound);
    worst = std::max(worst, apart), ratio = std::max(ratio, apart / bound);
    CHECK(apart <= bound);
    // A second conversion to URDF loses nothing more.
    CHECK(io::to_urdf(again, "", "").diagnostics.size() <= 2);
  }
  CHECK(roots > 100);
  CHECK(chains > 1000);
  MESSAGE("worst difference of accelerations: " << worst << ", " << ratio << " of its bound");
}

TEST_CASE("models of robots, as URDF and back") {
  for (const std::string file :
       {"panda/panda.urdf", "ur5/ur5_robot.urdf", "anymal_b/anymal.urdf", "simple_humanoid/simple_humanoid.urdf",
        "double_pendulum/double_pendulum.urdf", "iiwa14/iiwa14_no_collision.urdf", "mjcf_humanoid/humanoid.xml"}) {
    CAPTURE(file);
    const io::ReadResult first = io::read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/models/" + file);
    REQUIRE(first.scenario);
    Model model({.gravity = first.scenario->model.gravity()});
    for (BodySpec spec : first.scenario->model.bodies()) {
      spec.joint.parameters.stiffness = {}, spec.joint.parameters.armature = {};  // not in URDF
      model.add_unjudged(spec);
    }
    const io::Converted converted = io::to_urdf(*first.scenario, "", "/nowhere");
    const io::Scenario again =
        read(converted.text, "r.urdf",
             is_free(converted) ? std::vector<std::string>{"mechanism.r.root=free"} : std::vector<std::string>{});
    Prng random(5);
    for (int state = 0; state < 20; ++state) {
      double bound = 0;
      const double apart = compare(model, again.model, random, bound);
      CHECK(apart <= bound);
    }
  }
}

TEST_CASE("losses in URDF are reported once, with their place; models that URDF cannot express are refused") {
  const std::string head = "format = 1\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n";
  const auto said = [](const io::Converted& converted) {
    std::string all;
    for (const io::Diagnostic& each : converted.diagnostics) all += each.message() + "\n";
    return all;
  };
  const std::string joint = head + "[mechanism.body.joint]\nkind = \"revolute\"\n";
  const io::Scenario spring =
      read(joint + "stiffness = 2\narmature = 1\nangle = 1\n[[event]]\nat = 1\nbreak = \"m/a\"\n", "s.toml", {});
  const std::string words = said(io::to_urdf(spring, "m", ""));
  CHECK(words.find("s.toml:10:13: warning: URDF cannot express springs; left out at 'm/a'") != std::string::npos);
  CHECK(words.find("s.toml:11:12: warning: URDF cannot express armatures; left out at 'm/a'") != std::string::npos);
  CHECK(words.find("s.toml:12:9: warning: URDF cannot express starts; left out at 'm/a'") != std::string::npos);
  CHECK(words.find("s.toml: warning: a URDF holds only a model; left out: its events") != std::string::npos);
  CHECK(said(io::to_urdf(read(joint, "s.toml", {}), "", "")) == "");
  const auto refused = [](const io::Scenario& scenario, const char* mechanism) {
    try {
      io::to_urdf(scenario, mechanism, "");
    } catch (const Error& error) {
      return error.message();
    }
    return std::string();
  };
  CHECK(refused(read(head + "[mechanism.body.joint]\nkind = \"helical\"\npitch = 1\n", "s.toml", {}), "") ==
        "s.toml: error: URDF has no such joint: 'm/a' is helical; write a .toml, or change the joint's kind");
  CHECK(refused(read(joint, "s.toml", {}), "n") == "s.toml: error: there is no mechanism 'n'; known: 'm'");
  const std::string two = joint + "[[mechanism]]\nname = \"n\"\n[mechanism.chain]\nlinks = 2\nlength = 1\nmass = 1\n";
  CHECK(refused(read(two, "s.toml", {}), "") ==
        "s.toml: error: a URDF holds one mechanism, but the scenario has 2: 'm', 'n'; choose one with --mechanism NAME");
  CHECK(refused(read(two, "s.toml", {}), "n").empty());
}

}  // namespace momentree::oracle
