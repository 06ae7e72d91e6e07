#pragma once
// The points at which two solids with faces touch that may overlap, for time stepping: the direction in which they overlap least,
// and the points of one of them below the face of the other.
#include <cmath>
#include <vector>

#include <momentree/contact/candidates.hpp>

namespace momentree::contact {

class OverlapPoints {
 public:
  /// Appends the points of two solids with faces that overlap, or are nearer than `within` (m). A point on a face of one solid is
  /// a feature of that solid, although it need not be a vertex.
  void find(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
            std::vector<Candidate>& out);

 private:
  struct Above {
    double gap = -HUGE_VAL;
    std::size_t face = 0;
  };
  static Above highest(const Solid& solid, const Place& place, const Solid& other, const Place& of_other);
  void clip(const Solid& solid, const Place& place, const Solid& face_of, const Place& of_face, std::size_t face, bool swapped,
            double within, std::vector<Candidate>& out);

  std::vector<Candidate> edges_;
  std::vector<Vec3> polygon_, clipped_;
};

}  // namespace momentree::contact
