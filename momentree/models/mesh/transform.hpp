#pragma once
// Affine maps of points: the placements of nodes in Collada and glTF. Internal to the mesh reader.
#include <momentree/math/vec.hpp>

namespace momentree::io::mesh {

/// p ↦ m p + t, with m in rows.
struct Affine {
  double m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double t[3] = {0, 0, 0};

  Vec3 operator()(const Vec3& p) const {
    const auto row = [&](int i) { return m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z + t[i]; };
    return {row(0), row(1), row(2)};
  }
  /// First `b`, then this.
  Affine operator*(const Affine& b) const {
    Affine c;
    for (int i = 0; i < 3; ++i) {
      c.t[i] = t[i];
      for (int k = 0; k < 3; ++k) c.t[i] += m[i][k] * b.t[k];
      for (int j = 0; j < 3; ++j) {
        c.m[i][j] = 0;
        for (int k = 0; k < 3; ++k) c.m[i][j] += m[i][k] * b.m[k][j];
      }
    }
    return c;
  }
  bool mirrors() const {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0;
  }
};

inline Affine translation(const Vec3& t) {
  Affine a;
  a.t[0] = t.x, a.t[1] = t.y, a.t[2] = t.z;
  return a;
}
inline Affine scaling(const Vec3& s) {
  Affine a;
  a.m[0][0] = s.x, a.m[1][1] = s.y, a.m[2][2] = s.z;
  return a;
}
inline Affine rotation(const Quat& q) {
  const auto r = rotation_matrix(q);
  Affine a;
  const Vec3 columns[3] = {r * Vec3{1, 0, 0}, r * Vec3{0, 1, 0}, r * Vec3{0, 0, 1}};
  for (int j = 0; j < 3; ++j) a.m[0][j] = columns[j].x, a.m[1][j] = columns[j].y, a.m[2][j] = columns[j].z;
  return a;
}

}  // namespace momentree::io::mesh
