#pragma once
// The equations that hold a joint closed when it is not part of the tree: φ(R, r) = 0 for the pose (R, r) of its child-side frame
// in its parent-side frame. Each kind lists its own; their gradients are exact, so that φ is an invariant of the motion.
#include <array>

#include <momentree/math/vec.hpp>

namespace momentree {

struct Closure {
  /// φ = a · (R b) − c: directions a on the parent side and b on the child side enclose a constant angle.
  struct Direction {
    Vec3 a{}, b{};
    double c = 0;
  };
  /// φ = n · r − h θ: a screw of h metres per radian about the unit vector n; θ is measured from e1 to R e1 and continues over
  /// full turns. e1, e2, n are orthonormal.
  struct Screw {
    Vec3 n{}, e1{}, e2{};
    double h = 0;
  };
  int positions = 0, directions = 0, screws = 0;
  std::array<Vec3, 3> position{};  ///< φ = n · r
  std::array<Direction, 3> direction{};
  Screw screw{};

  int rows() const { return positions + directions + screws; }

  void add_position(const Vec3& n) { position[static_cast<std::size_t>(positions++)] = n; }
  void add_direction(const Vec3& a, const Vec3& b) { direction[static_cast<std::size_t>(directions++)] = {a, b, dot(a, b)}; }
  /// The origins coincide.
  void add_point() { add_position({1, 0, 0}), add_position({0, 1, 0}), add_position({0, 0, 1}); }
  /// The axes coincide.
  void add_rotation() {
    add_direction({0, 0, 1}, {0, 1, 0}), add_direction({1, 0, 0}, {0, 0, 1}), add_direction({0, 1, 0}, {1, 0, 0});
  }
  /// r is along the unit vector n.
  void add_line(const Vec3& n) {
    const Vec3 t = perpendicular(n);
    add_position(t), add_position(cross(n, t));
  }
  /// R leaves the unit vector n unchanged.
  void add_axis(const Vec3& n) {
    const Vec3 t = perpendicular(n);
    add_direction(t, n), add_direction(cross(n, t), n);
  }
  void add_screw(const Vec3& n, double h) {
    const Vec3 t = perpendicular(n);
    screw = {n, t, cross(n, t), h}, screws = 1;
  }

  static Vec3 perpendicular(const Vec3& n) {
    const double x = n.x * n.x, y = n.y * n.y, z = n.z * n.z;
    const Vec3 e = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    return normalized(cross(n, e));
  }
};

}  // namespace momentree
