#include "loop_models.hpp"

#include <cmath>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <string>

#include "models.hpp"

namespace momentree::bench {

namespace {

std::string name(const char* what, int k) { return std::string("b/") + what + std::to_string(k); }

BodySpec rod(const std::string& name, double length, double mass) {
  BodySpec body;
  body.name = name;
  body.mass = mass;
  body.com = {length / 2, 0, 0};
  body.inertia = diagonal(1e-4, mass * length * length / 12, mass * length * length / 12);
  body.joint = Revolute{.axis = y_axis};
  return body;
}

// Pose of a body in the world at the start.
Pose start_pose(const Model& model, BodyId body) {
  const Tree tree = compile(model);
  const State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  locate_bodies(tree, state, workspace);
  return user_pose(tree, workspace.bodies[static_cast<std::size_t>(body.index)], body.index);
}
// A weld between a body and another one, or the ground, as they stand at the start.
void weld_at_start(Model& model, const std::string& name, BodyId body, BodyId to) {
  const Pose there = to == ground ? Pose{} : start_pose(model, to);
  model.add_loop({.name = name, .body = body, .to = to, .joint = Weld{}, .at = inverse(there) * start_pose(model, body)});
}

}  // namespace

Model four_bar(int /*bodies*/) {
  Model model;
  const Pose tilted{{}, normalized(Quat{0.9, 0.2, 0.1, 0.3})};
  BodySpec crank = rod("b/crank", 0.12, 2), coupler = rod("b/coupler", 0.38, 1), rocker = rod("b/rocker", 0.25, 1);
  crank.at = tilted, crank.q = -1.05, crank.v = 8.0;
  rocker.at = tilted * Pose{{0.4, 0, 0}, {}}, rocker.q = -1.55;
  coupler.parent = model.add(crank), coupler.at = {0.12, 0, 0}, coupler.q = 0.7;
  const BodyId child = model.add(coupler), other = model.add(rocker);
  model.add_loop({.name = "closure",
                  .body = child,
                  .to = other,
                  .joint = Revolute{.axis = y_axis},
                  .at = {0.25, 0, 0},
                  .child_at = {0.38, 0, 0}});
  return model;
}

Model four_bars(int windows) {
  Model model;
  std::vector<BodyId> up;
  for (int i = 0; i <= windows; ++i) {
    BodySpec body = rod(name("up", i), 1, 1);
    body.at = {static_cast<double>(i), 0, 0}, body.q = -1.3, body.v = 1.0;
    up.push_back(model.add(body));
  }
  for (int i = 0; i < windows; ++i) {
    BodySpec body = rod(name("across", i), 1, 1);
    body.parent = up[static_cast<std::size_t>(i)], body.at = {1, 0, 0}, body.q = 1.3, body.v = -1.0;
    model.add_loop({.name = name("loop", i),
                    .body = model.add(body),
                    .to = up[static_cast<std::size_t>(i) + 1],
                    .joint = Revolute{.axis = y_axis},
                    .at = {1, 0, 0},
                    .child_at = {1, 0, 0}});
  }
  return model;
}

Model suspended_chain(int bodies) {
  Model model;
  BodyId last = ground;
  for (int i = 0; i < bodies; ++i) {
    BodySpec body = rod(name("link", i), 0.1, 0.1);
    body.inertia = diagonal(1e-5, 1e-4, 1e-4);
    body.parent = last, body.joint = Ball{};
    if (i > 0) body.at = {0.1, 0, 0};
    const double a = (i == 0 ? 0.6 : -1.2 / bodies) / 2;
    body.q = {std::cos(a), 0, std::sin(a), 0};
    body.v = {0.1 * i, 0.2, -0.1};
    last = model.add(body);
  }
  model.add_loop({.name = "end", .body = last, .joint = Ball{}, .at = {0.0942 * bodies, 0, 0}, .child_at = {0.1, 0, 0}});
  return model;
}

Model ring(int bodies) {
  const Model open = spatial_chain(bodies);
  Model model;
  for (BodySpec body : open.bodies()) {
    if (body.parent == ground) body.joint = Free{}, body.q = {}, body.v = {};
    model.add(body);
  }
  const BodyId last{bodies - 1};
  model.add_loop({.name = "clasp",
                  .body = last,
                  .to = {0},
                  .joint = Ball{},
                  .at = inverse(start_pose(model, {0})) * start_pose(model, last)});
  return model;
}

Model two_arms(int /*bodies*/) {
  const Model one = arm(7);
  Model model;
  BodyId hands[2];
  for (const int side : {0, 1}) {
    const int first = static_cast<int>(model.bodies().size());
    for (BodySpec body : one.bodies()) {
      body.name += side == 0 ? "_left" : "_right";
      body.joint_name.clear();
      if (body.parent == ground)
        body.at = Pose{{0, 0.6 * side, 0}, {}} * body.at;
      else
        body.parent = {body.parent.index + first};
      hands[side] = model.add(body);
    }
  }
  BodySpec bar = rod("b/bar", 0.6, 2);
  bar.parent = hands[0], bar.joint = Weld{};
  weld_at_start(model, "grip", model.add(bar), hands[1]);
  return model;
}

Model standing_humanoid(int bodies) {
  Model model = humanoid(bodies);
  weld_at_start(model, "left sole", {6}, ground);
  weld_at_start(model, "right sole", {12}, ground);
  return model;
}

}  // namespace momentree::bench
