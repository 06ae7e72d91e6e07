#include "models.hpp"

#include <cstdint>
#include <momentree/joint/kinds.hpp>
#include <string>

namespace momentree::bench {
namespace {

// SplitMix64: the same numbers with every compiler and library. One draw per statement: the order of arguments is not fixed.
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

Model planar_chain(int bodies) {
  Model model({.gravity = {0, -9.81, 0}});
  Body link = ground;
  for (int k = 1; k <= bodies; ++k)
    link = model.add({.name = "b/" + std::to_string(k),
                      .mass = 0.010,
                      .com = {0.025, 0, 0},
                      .inertia = diagonal(2.083e-6),
                      .parent = link,
                      .at = {k == 1 ? 0.0 : 0.05, 0, 0},
                      .joint = Revolute{.axis = z_axis, .damping = 1e-5},
                      .q = 0.001 * k,
                      .v = 0.1});
  return model;
}

Model spatial_chain(int bodies) {
  Random random(1);
  Model model;
  Body parent = ground;
  for (int k = 1; k <= bodies; ++k) {
    BodySpec body = general_body(k, random);
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
    body.parent = k == 1 ? ground : Body{static_cast<int>(earlier)};
    model.add(body);
  }
  return model;
}

Model humanoid(int) {
  Model model;
  Body trunk = model.add({.name = "trunk", .mass = 20, .com = {0, 0, 0.2}, .inertia = diagonal(0.8, 0.7, 0.3), .joint = Free{}});
  // Limbs: where they hang, and the axes of their joints; every third link is long.
  struct Limb {
    const char* name;
    Vec3 at;
    const char* axes;
    double mass;
  };
  constexpr Limb limbs[] = {{"neck", {0, 0, 0.5}, "zyx", 2},
                            {"torso", {0, 0, 0.25}, "z", 8},
                            {"left_arm", {0, 0.2, 0.45}, "yxzyzyx", 1.2},
                            {"right_arm", {0, -0.2, 0.45}, "yxzyzyx", 1.2},
                            {"left_leg", {0, 0.1, 0}, "zxyyyx", 4},
                            {"right_leg", {0, -0.1, 0}, "zxyyyx", 4}};
  for (const Limb& limb : limbs) {
    Body parent = trunk;
    for (int k = 0; limb.axes[k] != 0; ++k) {
      const Vec3 axis = limb.axes[k] == 'x' ? x_axis : limb.axes[k] == 'y' ? y_axis : z_axis;
      parent = model.add({.name = std::string(limb.name) + "/" + std::to_string(k),
                          .mass = limb.mass,
                          .com = {0, 0, -0.1},
                          .inertia = diagonal(0.02, 0.018, 0.005),
                          .parent = parent,
                          .at = Pose{k == 0 ? limb.at : Vec3{0, 0, k % 3 == 0 ? -0.35 : 0.0}},
                          .joint = Revolute{.axis = axis, .damping = 1e-2},
                          .q = 0.1 * (k + 1),
                          .v = 0.05 * k});
    }
  }
  return model;
}

}  // namespace momentree::bench
