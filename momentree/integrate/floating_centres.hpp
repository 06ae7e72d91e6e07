#pragma once
// Positions of floating bodies during a step. Their coordinates belong to the origin of the user's frame, which circles about the
// centre of mass while the body spins: steps would be short because of that motion alone. What is integrated instead is the
// motion of the centre, r + R c, and the origin follows from it and the rotation at every stage.
#include <cstdint>
#include <optional>
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree {

class FloatingCentres {
 public:
  /// For trees with at most that many bodies.
  explicit FloatingCentres(int bodies) { all_.reserve(static_cast<std::size_t>(bodies)); }

  /// A step begins at coordinates q of this tree.
  void begin(const Tree& tree, const double* q) noexcept;
  /// Adds to q̇ what makes it the rate of the centres, at coordinates q and joint velocities u.
  void add_spin(const double* q, const double* u, double* qdot) const noexcept;
  /// From coordinates at the start of the step plus displacements of the centres to coordinates.
  void place(double* q) const noexcept;
  /// From errors of centres and quaternions to those of coordinates, at q.
  void add_turn(const double* q, double* error) const noexcept;

 private:
  struct Body {
    int q, u;
    Vec3 c;      ///< from the origin to the centre, in the body's axes (m)
    Vec3 start;  ///< the same at the start of the step, in the parent-side axes
  };
  std::vector<Body> all_;
  std::optional<std::uint64_t> revision_;
};

}  // namespace momentree
