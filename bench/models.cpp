#include "models.hpp"

#include <cstdint>
#include <initializer_list>
#include <momentree/joint/kinds.hpp>
#include <string>

namespace momentree::bench {
namespace {

// SplitMix64: the same numbers with every compiler and library. One draw per statement: the order of evaluation of arguments is
// not defined.
class Random {
 public:
  explicit Random(std::uint64_t seed) : at_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = at_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53); }
  Vec3 vector(double half_width) {
    const double x = between(-half_width, half_width);
    const double y = between(-half_width, half_width);
    const double z = between(-half_width, half_width);
    return {x, y, z};
  }

 private:
  std::uint64_t at_;
};

BodySpec general_body(int k, Random& random) {
  BodySpec body;
  body.name = "b/" + std::to_string(k);
  body.mass = random.between(0.5, 2);
  body.com = random.vector(0.2);
  const Vec3 half = random.vector(0.1);
  body.inertia = diagonal(0.02);
  body.inertia.xx += half.x * half.x;
  body.inertia.xy = 0.1 * half.x * half.y;
  body.inertia.yz = 0.1 * half.y * half.z;
  body.at.position = random.vector(0.3);
  Quat turn;
  turn.w = random.between(0.2, 1);
  const Vec3 about = random.vector(1);
  turn.x = about.x, turn.y = about.y, turn.z = about.z;
  body.at.rotation = normalized(turn);
  Vec3 axis = random.vector(1);
  axis.z += 1.5;
  body.joint = Revolute{.axis = axis, .damping = 1e-3};
  body.q = random.between(-2, 2);
  body.v = random.between(-1, 1);
  return body;
}

}  // namespace

namespace {

Model rods(int bodies, double speed) {
  Model model({.gravity = {0, -9.81, 0}});
  BodyId link = ground;
  for (int k = 1; k <= bodies; ++k)
    link = model.add({.name = "b/" + std::to_string(k),
                      .mass = 0.010,
                      .com = {0.025, 0, 0},
                      .inertia = diagonal(2.083e-6),
                      .parent = link,
                      .at = {k == 1 ? 0.0 : 0.05, 0, 0},
                      .joint = Revolute{.axis = z_axis, .damping = 1e-5},
                      .q = 0.001 * k,
                      .v = speed});
  return model;
}

}  // namespace

Model planar_chain(int bodies) { return rods(bodies, 0.1); }

Model floating_chain(int bodies) {
  const Model held = rods(bodies, 0.1);
  Model model({.gravity = held.gravity()});
  for (int k = 0; k < bodies; ++k) {
    BodySpec body = held[{k}];
    if (k == 0) body.joint = Free{}, body.q = {}, body.v = {};
    model.add(body);
  }
  return model;
}

Model breaking_chain() { return rods(100, 0); }

Model rope(int bodies) {
  Model model;
  BodyId link = ground;
  for (int k = 1; k <= bodies; ++k)
    link = model.add({.name = "b/" + std::to_string(k),
                      .mass = 0.010,
                      .com = {0.025, 0, 0},
                      .inertia = {1e-7, 2.083e-6, 2.083e-6},
                      .parent = link,
                      .at = {k == 1 ? 0.0 : 0.05, 0, 0},
                      .joint = Revolute{.axis = k % 2 == 0 ? y_axis : z_axis, .damping = 1e-5},
                      .q = 0.001 * (k % 7 - 3),
                      .v = 0.001 * (k % 5 - 2)});
  return model;
}

Model spatial_chain(int bodies) {
  Random random(1);
  Model model;
  BodyId parent = ground;
  for (int k = 1; k <= bodies; ++k) {
    BodySpec body = general_body(k, random);
    body.parent = parent;
    parent = model.add(body);
  }
  return model;
}

Model twisted_chain(int bodies) {
  Random random(3);
  Model model;
  BodyId parent = ground;
  for (int k = 1; k <= bodies; ++k) {
    BodySpec body = general_body(k, random);
    const double alpha = random.between(0.6, 2.5);
    const double turn = random.between(-3, 3);
    body.at.rotation = from_axis_angle(z_axis, turn) * from_axis_angle(x_axis, alpha);
    body.joint = Revolute{.axis = z_axis, .damping = 1e-3};
    body.parent = parent;
    parent = model.add(body);
  }
  return model;
}

Model bushy_tree(int bodies) {
  Random random(2);
  Model model;
  for (int k = 1; k <= bodies; ++k) {
    BodySpec body = general_body(k, random);
    const auto earlier = random.bits() % static_cast<std::uint64_t>(k == 1 ? 1 : k - 1);
    body.parent = k == 1 ? ground : BodyId{static_cast<int>(earlier)};
    model.add(body);
  }
  return model;
}

Model binary_tree(int bodies) {
  Random random(4);
  Model model;
  for (int k = 1; k <= bodies; ++k) {
    BodySpec body = general_body(k, random);
    body.parent = k == 1 ? ground : BodyId{k / 2 - 1};
    model.add(body);
  }
  return model;
}

Model arm(int bodies) {
  struct Part {
    double mass, length;
    Vec3 com, inertia;
  };
  static constexpr Part parts[] = {
      {4.0, 0.36, {0, -0.03, 0.12}, {0.05, 0.045, 0.012}}, {4.0, 0, {0, 0.06, 0.04}, {0.05, 0.02, 0.04}},
      {3.0, 0.42, {0, 0.03, 0.13}, {0.03, 0.028, 0.008}},  {2.7, 0, {0, 0.07, 0.03}, {0.03, 0.01, 0.025}},
      {1.7, 0.40, {0, -0.02, 0.08}, {0.012, 0.01, 0.004}}, {1.8, 0, {0, 0, 0.01}, {0.005, 0.004, 0.005}},
      {0.3, 0.08, {0, 0, 0.02}, {0.001, 0.001, 0.001}}};
  constexpr double right = 1.5707963267948966;
  Model model;
  BodyId parent = ground;
  for (int k = 0; k < bodies; ++k) {
    const Part& part = parts[k % 7];
    BodySpec body;
    body.name = "b/" + std::to_string(k + 1);
    body.mass = part.mass, body.com = part.com;
    body.inertia = diagonal(part.inertia.x, part.inertia.y, part.inertia.z);
    body.parent = parent;
    // Every second axis is perpendicular to the link, the others are along it; lengths are along the latter.
    body.at.position = k == 0 ? Vec3{0, 0, part.length} : k % 2 == 0 ? Vec3{0, part.length, 0} : Vec3{};
    if (k > 0) body.at.rotation = from_axis_angle(x_axis, k % 2 == 0 ? -right : right);
    body.joint = Revolute{.axis = z_axis, .damping = 0.5};
    body.q = 0.3 * k - 0.7, body.v = 0.1 * k;
    parent = model.add(body);
  }
  return model;
}

Model humanoid(int /*bodies*/) {
  Random random(5);
  Model model;
  int k = 0;
  const auto add = [&](BodyId parent, const JointSpec& joint, const Vec3& at) {
    BodySpec body = general_body(++k, random);
    body.parent = parent;
    body.at = {at, {}};
    body.joint = joint;
    if (joint.kind == Kind::free) body.q = {0, 0, 1, 1, 0, 0, 0}, body.v = {0.1, -0.2, 0.3, 0.4, -0.5, 0.6};
    return model.add(body);
  };
  struct RevoluteAt {
    Vec3 axis, at;
  };
  const auto limb = [&](BodyId last, std::initializer_list<RevoluteAt> joints, double side) {
    for (const RevoluteAt& joint : joints)
      last = add(last, Revolute{.axis = joint.axis, .damping = 1e-3}, {joint.at.x, side * joint.at.y, joint.at.z});
    return last;
  };
  const BodyId pelvis = add(ground, Free{}, {});
  for (const double side : {1, -1})
    limb(pelvis,
         {{z_axis, {0, 0.1, -0.05}}, {x_axis, {}}, {y_axis, {}}, {y_axis, {0, 0, -0.4}}, {y_axis, {0, 0, -0.4}}, {x_axis, {}}},
         side);
  const BodyId chest = limb(pelvis, {{z_axis, {0, 0, 0.1}}, {y_axis, {}}}, 1);
  for (const double side : {1, -1})
    limb(chest,
         {{y_axis, {0, 0.2, 0.3}},
          {x_axis, {}},
          {z_axis, {}},
          {y_axis, {0, 0, -0.3}},
          {z_axis, {}},
          {y_axis, {0, 0, -0.25}},
          {x_axis, {}}},
         side);
  limb(chest, {{z_axis, {0, 0, 0.4}}, {y_axis, {}}}, 1);
  return model;
}

}  // namespace momentree::bench
