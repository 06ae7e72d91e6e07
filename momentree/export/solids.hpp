#pragma once
// The solids of bodies: their shapes, the ellipsoids of bodies without shapes, and their lines as rods.
#include <vector>

#include <momentree/export/drawing.hpp>

namespace momentree::io {

/// A length compared with which rods are thin: the median of the lines of all bodies (m).
double typical_length(const Recording& run);

/// By body. Adds the surfaces of shapes that are no solids of a Drawing to the run's parts of meshes.
std::vector<std::vector<Solid>> solids_of(Recording& run, double typical_length);

/// The rotation that turns the z axis into a direction other than zero.
Quat along_z(const Vec3& direction);
/// The shortest rotation from one unit vector to another.
Quat shortest_turn(const Vec3& from, const Vec3& to);

/// The poses of a bar at successive rows: its middle, with z along it. It is turned as little as possible from row to row, so
/// that programs interpolate on the short way.
class BarPoses {
 public:
  Pose next(const Vec3& from, const Vec3& to);

 private:
  Vec3 direction_{0, 0, 1};
  Quat rotation_{};
};

/// The scale that makes a cylinder of diameter and length 1 along z this bar.
Vec3 bar_scale(double radius, const Vec3& from, const Vec3& to);

}  // namespace momentree::io
