// A model and its text for other engines: equal momenta give equal velocities and equal rates.
#include <cli/bench/peer_links.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <sstream>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/scenario/scenario.hpp>

namespace momentree::cli {

namespace {

/// The model without the properties that other engines are not given.
Model bare(const Model& model) {
  Model plain({.gravity = model.gravity()});
  for (BodySpec body : model.bodies()) {
    body.joint.parameters = {};
    plain.add_unjudged(body);
  }
  return plain;
}

/// The model that a reader makes of the text.
Model read_links(const std::string& text, const Vec3& gravity) {
  std::istringstream lines(text);
  std::string line;
  REQUIRE(std::getline(lines, line));
  Model model({.gravity = gravity});
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string joint;
    Mat3 R;
    BodySpec body;
    words >> body.parent.index >> joint >> R.xx >> R.xy >> R.xz >> R.yx >> R.yy >> R.yz >> R.zx >> R.zy >> R.zz;
    words >> body.at.position.x >> body.at.position.y >> body.at.position.z >> body.mass >> body.com.x >> body.com.y >>
        body.com.z;
    Sym3& I = body.inertia;
    words >> I.xx >> I.yy >> I.zz >> I.xy >> I.xz >> I.yz;
    REQUIRE(!words.fail());
    body.at.rotation = quaternion_of(R);
    body.name = "b" + std::to_string(model.size());
    if (joint == "free") body.joint = Free{};
    if (joint == "revolute") body.joint = Revolute{.axis = z_axis};
    if (joint == "prismatic") body.joint = Prismatic{.axis = z_axis};
    CHECK(body.joint.kind != Kind::weld);
    model.add_unjudged(body);
  }
  return model;
}

/// Rates of all DoFs in the order of the bodies, from coordinates and velocities that are equal in all models.
std::vector<double> rates(const Model& model) {
  const Tree tree(model);
  State state = start_state(model, tree);
  std::vector<double> q(state.q().begin(), state.q().end()), p(state.p().size()), v(state.p().size());
  int moving = 0;
  for (int b = 0; b < tree.bodies(); ++b) {
    const int nv = info(tree.kind(b)).nv;
    if (nv == 1) q[static_cast<std::size_t>(tree.first_q(b))] = 0.3 - 0.1 * (moving % 7);
    for (int i = 0; i < nv; ++i) v[static_cast<std::size_t>(tree.first_p(b) + i)] = 0.2 + 0.3 * ((moving + i) % 5);
    if (nv > 0) ++moving;
  }
  project_momentum(tree, q.data(), v.data(), p.data());
  state.assign(state.time(), q, p, tree);
  Workspace<double> work(tree);
  evaluate_rates(tree, q.data(), p.data(), work);
  std::vector<double> all = p;
  all.insert(all.end(), work.pdot.get(), work.pdot.get() + tree.nv());
  return all;
}

void check_same(const Model& model) {
  const Model plain = bare(model);
  const std::vector<double> ours = rates(plain), theirs = rates(read_links(peer_links("it", plain), plain.gravity()));
  REQUIRE(ours.size() == theirs.size());
  double largest = 0;
  for (const double x : ours) largest = std::max(largest, std::fabs(x));
  CHECK(largest > 0.01);
  for (std::size_t i = 0; i < ours.size(); ++i) CHECK(std::fabs(theirs[i] - ours[i]) <= 1e-11 * largest);
}

}  // namespace

TEST_CASE("links for other engines: real robots keep their dynamics") {
  const std::string folder = MOMENTREE_SOURCE_DIR "/scenarios/models/";
  for (const char* file :
       {"panda/panda.urdf", "ur5/ur5_robot.urdf", "anymal_b/anymal.urdf", "simple_humanoid/simple_humanoid.urdf",
        "iiwa14/iiwa14_no_collision.sdf", "mjcf_humanoid/humanoid.xml"}) {
    CAPTURE(file);
    const io::ReadResult read = io::read_scenario(folder + file, {});
    REQUIRE(read.scenario);
    check_same(read.scenario->model);
  }
}

TEST_CASE("links for other engines: welds anywhere, a free body whose frame is not its joint's, oblique axes") {
  const Quat turned = exp_rotation({0.3, -0.5, 0.7}), back = exp_rotation({-0.2, 0.1, 0.4});
  const auto body = [&](const char* name, BodyId parent, const JointSpec& joint) {
    BodySpec spec;
    spec.name = name, spec.mass = 1.3, spec.com = {0.1, -0.05, 0.2}, spec.inertia = {0.3, 0.4, 0.5, 0.02, -0.03, 0.04};
    spec.parent = parent, spec.joint = joint;
    spec.at = Pose{{0.2, 0.1, -0.3}, turned}, spec.child_at = Pose{{-0.1, 0.2, 0.1}, back};
    return spec;
  };
  const JointSpec pin = Revolute{.axis = {0.6, 0, 0.8}}, slide = Prismatic{.axis = {0, -0.6, 0.8}}, weld;
  Model floating;
  const BodyId hull = floating.add(body("hull", ground, Free{}));
  const BodyId mast = floating.add(body("mast", hull, weld));
  const BodyId boom = floating.add(body("boom", mast, pin));
  floating.add(body("trolley", boom, slide));
  floating.add(body("plate", boom, weld));
  floating.add(body("rudder", hull, pin));
  check_same(floating);

  Model grounded;
  const BodyId bench = grounded.add(body("bench", ground, weld));
  const BodyId left = grounded.add(body("left", bench, slide));
  grounded.add(body("right", bench, pin));
  grounded.add(body("hand", left, pin));
  grounded.add(body("alone", ground, pin));
  check_same(grounded);
}

TEST_CASE("links for other engines: unsupported joints are refused by name") {
  Model model;
  model.add({.name = "a", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Ball{}});
  CHECK_THROWS_AS(peer_links("it", model), Error);
  try {
    peer_links("it", model);
  } catch (const Error& error) {
    CHECK(error.problem == "other engines do not support this model: a has a ball joint");
    CHECK(error.hint.find("--peers") != std::string::npos);
  }
  Model two;
  two.add({.name = "a", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  two.add({.name = "b", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  CHECK_THROWS_AS(peer_links("it", two), Error);
  Model beside;
  beside.add({.name = "a", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  beside.add({.name = "b", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Revolute{}});
  CHECK_THROWS_AS(peer_links("it", beside), Error);
}

}  // namespace momentree::cli
