#pragma once
// The ground below a grid of heights: two triangles for each cell between four of them.
#include <cstdint>
#include <vector>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>

namespace momentree::contact {

/// Without sides: there is nothing beyond its border.
struct HeightField {
  Pose at{};                      ///< of its frame in the world; the grid is centred at its origin, heights are along its z
  double x = 0, y = 0;            ///< extent along these axes (m)
  int columns = 0, rows = 0;      ///< numbers of heights along x and y, at least 2
  std::vector<double> heights{};  ///< row by row from −y to y, in each from −x to x (m)
  double lowest = 0, highest = 0;
  /// By height, bits 0 to 2: the edges that begin there, along x, along y, and across the cell, are convex; bit 3: it is a
  /// corner.
  std::vector<std::uint8_t> convex{};

  friend bool operator==(const HeightField& a, const HeightField& b) {
    const Quat &p = a.at.rotation, &q = b.at.rotation;
    return a.at.position == b.at.position && p.w == q.w && p.x == q.x && p.y == q.y && p.z == q.z && a.x == b.x && a.y == b.y &&
           a.columns == b.columns && a.heights == b.heights;
  }
};

/// The diagonal of a cell goes from the end of its lower side to the beginning of its upper side, as in MuJoCo.
HeightField height_field(double x, double y, int columns, int rows, std::vector<double> heights, const Pose& at = {});

/// As face_each_other(), for a solid and the ground below a field. Points of the solid face the triangle below them; its edges,
/// and what is round, also convex edges and corners of the field. Only what is below the solid is looked at.
void face_field(const Solid& solid, const Place& place, const HeightField& field, double within, std::vector<Candidate>& out);

/// At most the distance of a ball from the field (m); not above zero: they may overlap.
double clearance(const HeightField& field, const Vec3& centre, double radius);

NearestPoints distance_to_field(const Solid& solid, const Place& place, const HeightField& field);

}  // namespace momentree::contact
