// The models of the evaluations with closed loops.
#include <algorithm>

#include "figure.hpp"
#include "loops.hpp"

namespace peers {
namespace {

const Matrix3d upright = Eigen::AngleAxisd(1.5707963267948966, Vector3d::UnitX()).toRotationMatrix();

/// A planar mechanism in an upright plane: x is horizontal, y points up.
struct Planar {
  explicit Planar(std::string name) { model.name = std::move(name), model.planar = true; }
  /// A body with a pin at (x, y) of its parent. The last three: its centre of mass, and its inertia about it.
  int add(int parent, double x, double y, double angle, double mass, double com_x, double com_y, double inertia) {
    Link link;
    link.name = "b" + std::to_string(model.links.size());
    link.parent = parent;
    link.at = {x, y, 0};
    if (parent < 0) link.turn = upright, link.at = upright * link.at;
    link.mass = mass, link.com = {com_x, com_y, 0};
    link.inertia = inertia * Vector3d(0.3, 0.8, 1);
    model.links.push_back(link);
    model.states[0].q.push_back(angle);
    return static_cast<int>(model.links.size()) - 1;
  }
  int rod(int parent, double x, double y, double angle, double length, double mass) {
    return add(parent, x, y, angle, mass, length / 2, 0, mass * length * length / 12);
  }
  /// A pin between (x, y) of a body and a point of another body, or of the ground.
  void close(int body, double x, double y, int to, double to_x, double to_y) {
    LoopJoint loop;
    loop.body = body, loop.to = to;
    loop.at = {x, y, 0}, loop.to_at = {to_x, to_y, 0};
    if (to < 0) loop.to_turn = upright, loop.to_at = upright * loop.to_at;
    model.loops.push_back(loop);
  }
  LoopModel done() {
    complete(model);
    return model;
  }
  LoopModel model;
};

LoopModel four_bar() {
  Planar mechanism("four-bar");
  const int crank = mechanism.rod(-1, 0, 0, 1.1, 0.2, 0.5);
  const int coupler = mechanism.rod(crank, 0.2, 0, -0.8, 0.5, 1);
  const int rocker = mechanism.rod(coupler, 0.5, 0, -1.5, 0.3, 0.7);
  mechanism.close(rocker, 0.3, 0, -1, 0.5, 0);
  return mechanism.done();
}

/// Andrews' squeezing mechanism without its spring: K1, K2, K3, K5, K4, K7, K6 of the Test Set for IVP Solvers, at its start.
LoopModel andrews() {
  Planar mechanism("Andrews");
  const int k1 = mechanism.add(-1, 0, 0, -0.0617138900142764496, 0.04325, 0.00092, 0, 2.194e-6);
  const int k2 = mechanism.add(k1, 0.007, 0, 0, 0.00365, -0.0115, 0, 4.41e-7);
  const int k3 = mechanism.add(-1, -0.03635, 0.03273, 0.45527981916307038, 0.02373, 0.01043, -0.01874, 5.255e-6);
  const int k5 = mechanism.add(-1, -0.06934, -0.00227, 0.48736497954384255, 0.0705, 0.02308, 0.00916, 1.169e-5);
  const int k4 = mechanism.add(k5, 0.04, 0, 0.222668390165885884, 0.00706, 0, -0.00579, 5.667e-7);
  const int k7 = mechanism.add(-1, -0.06934, -0.00227, 1.23054744454982119, 0.05498, -0.00449, -0.01228, 1.912e-5);
  const int k6 = mechanism.add(k7, 0, -0.04, -0.222668390165885884, 0.00706, 0.00579, 0, 5.667e-7);
  mechanism.close(k3, 0, -0.035, k2, -0.028, 0);
  mechanism.close(k4, 0, -0.02, k2, -0.028, 0);
  mechanism.close(k6, 0.02, 0, k2, -0.028, 0);
  return mechanism.done();
}

/// A row of windows: the problem A02 of the IFToMM benchmarks. Rods of 1 m and 1 kg.
LoopModel windows(int count) {
  Planar mechanism(std::to_string(count) + " four-bars");
  const double angle = 1.2;
  int post = mechanism.rod(-1, 0, 0, angle, 1, 1);
  for (int i = 0; i < count; ++i) {
    const int beam = mechanism.rod(post, 1, 0, -angle, 1, 1);
    post = mechanism.rod(-1, i + 1, 0, angle, 1, 1);
    mechanism.close(beam, 1, 0, post, 1, 0);
  }
  return mechanism.done();
}

LoopModel welded(std::string name, const std::vector<Link>& links, const std::vector<LoopJoint>& loops) {
  LoopModel model{std::move(name), links, loops, false, {}, {}};
  for (const Link& link : links) model.states[0].q.push_back(link.angle);
  complete(model);
  return model;
}

/// The humanoid of the evaluations, its feet welded to the ground.
LoopModel standing() {
  const std::vector<EvaluationModel> all = models({});
  LoopJoint left, right;
  left.body = 6, right.body = 12;
  left.at = right.at = {0, 0, -0.05};
  return welded("standing humanoid", all.back().links, {left, right});
}

/// Two grounded arms of seven joints. The last link of the first one carries a bar, whose end is welded to the second hand.
LoopModel two_arms() {
  Figure figure(9);
  int hands[2];
  for (int k = 0; k < 2; ++k) {
    const int base = figure.add(-1, 'z', {0, k == 0 ? 0.3 : -0.3, 0.5});
    hands[k] = figure.limb(base, "yzyzyz", {{0, 0, 0.2}, {0, 0, 0.2}, {0, 0, 0.2}, {0, 0, 0.2}, {0, 0, 0.2}, {0, 0, 0.1}});
  }
  Link& hand = figure.links[static_cast<std::size_t>(hands[0])];
  hand.mass += 2, hand.com = {0.2, 0, 0.05}, hand.inertia = Vector3d(0.01, 0.12, 0.12);
  LoopJoint grip;
  grip.body = hands[1], grip.to = hands[0];
  grip.at = {0, 0, 0.1};
  return welded("two arms", figure.links, {grip});
}

}  // namespace

std::vector<LoopModel> loop_models() { return {four_bar(), andrews(), windows(40), standing(), two_arms()}; }

}  // namespace peers
