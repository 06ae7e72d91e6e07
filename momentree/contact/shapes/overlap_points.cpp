#include <momentree/contact/shapes/overlap_points.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/contact/candidates_impl.hpp>
#include <momentree/contact/shapes/cylinder_overlap.hpp>
#include <momentree/contact/shapes/cylinder_pair.hpp>

namespace momentree::contact {

// The face of the other solid above which the solid is the most, or below which it is the least.
OverlapPoints::Above OverlapPoints::highest(const Solid& solid, const Place& place, const Solid& other, const Place& of_other) {
  const Vec3 from = transpose_times(place.R, of_other.r - place.r);
  Above found;
  for (std::size_t f = 0; f < other.faces.size(); ++f) {
    const Vec3 normal = transpose_times(place.R, of_other.R * other.faces[f].normal);
    double lowest = HUGE_VAL;
    for (const Vec3& v : solid.vertices) lowest = std::min(lowest, dot(normal, v));
    const double gap = lowest - other.faces[f].offset - dot(normal, from);
    if (gap > found.gap) found = {gap, f};
  }
  found.gap -= solid.radius + other.radius;
  return found;
}

// The part before a face of the face of the solid that is opposite to it.
void OverlapPoints::clip(const Solid& solid, const Place& place, const Solid& face_of, const Place& of_face, std::size_t face,
                         bool swapped, double within, std::vector<Candidate>& out) {
  const Solid::Face& reference = face_of.faces[face];
  const Vec3 normal = transpose_times(place.R, of_face.R * reference.normal);
  std::size_t opposite = 0;
  for (std::size_t f = 1; f < solid.faces.size(); ++f)
    if (dot(solid.faces[f].normal, normal) < dot(solid.faces[opposite].normal, normal) - 1e-9) opposite = f;
  const auto into_solid = [&](const Vec3& own) { return transpose_times(place.R, of_face.r + of_face.R * own - place.r); };
  polygon_.clear();
  for (const int corner : solid.faces[opposite].corners) polygon_.push_back(solid.vertices[at(corner)]);
  for (std::size_t k = 0; k < reference.corners.size() && !polygon_.empty(); ++k) {
    const Vec3 a = into_solid(face_of.vertices[at(reference.corners[k])]),
               b = into_solid(face_of.vertices[at(reference.corners[(k + 1) % reference.corners.size()])]);
    const Vec3 inward = cross(normal, b - a);
    clipped_.clear();
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Vec3 &p = polygon_[i], &next = polygon_[(i + 1) % polygon_.size()];
      const double here = dot(inward, p - a), there = dot(inward, next - a);
      if (here >= 0) clipped_.push_back(p);
      if ((here < 0) != (there < 0)) clipped_.push_back(p + (here / (here - there)) * (next - p));
    }
    polygon_.swap(clipped_);
  }
  Features features{FeaturePair::point_plane, {}, {}, face_of.vertices[at(reference.corners[0])], reference.normal};
  features.radius_a = solid.radius, features.radius_b = face_of.radius;
  const Place &place_a = place, &place_b = of_face;
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    features.point_a = polygon_[i];
    const double gap = touch(features, place_a, place_b).gap;
    const std::uint64_t id =
        (swapped ? 8u : 0u) | std::uint64_t{i} << 4 | std::uint64_t{opposite} << 14 | std::uint64_t{face} << 34;
    if (gap < within) out.push_back({features, swapped, id, gap});
  }
}

void OverlapPoints::find(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                         std::vector<Candidate>& out) {
  if (one.rim > 0 && other.rim > 0) return cylinders_overlap_points(one, place_one, other, place_other, within, out);
  if (one.rim > 0 && other.rim == 0) return cylinder_overlap_points(one, place_one, other, place_other, false, within, out);
  if (other.rim > 0 && one.rim == 0) return cylinder_overlap_points(other, place_other, one, place_one, true, within, out);
  const Above above_other = highest(one, place_one, other, place_other);
  if (above_other.gap > within) return;
  const Above above_one = highest(other, place_other, one, place_one);
  if (above_one.gap > within) return;
  const double gap = std::max(above_other.gap, above_one.gap);
  edges_.clear();
  cross_edges(one, place_one, other, place_other, within, -gap, edges_);
  const auto least =
      std::max_element(edges_.begin(), edges_.end(), [](const Candidate& a, const Candidate& b) { return a.gap < b.gap; });
  const double more = nearly_parallel * std::min(one.thickness, other.thickness);
  if (least != edges_.end() && least->gap > std::max(clearly_less * gap, gap) + more) {
    out.push_back(*least);
    return;
  }
  // Of equal faces that of the second solid, so that the choice does not alternate.
  if (above_other.gap >= above_one.gap - 1e-3 * std::fabs(gap))
    clip(one, place_one, other, place_other, above_other.face, false, within, out);
  else
    clip(other, place_other, one, place_one, above_one.face, true, within, out);
}

}  // namespace momentree::contact
