#pragma once
// The shape of a body, for pictures, or for what it touches with. It has no mass.
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <momentree/contact/primitive.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io {

struct MeshSource;
struct HeightGrid;

/// The optional `shape` of a body in a scenario, or one of the visuals or collision elements of a model file; SI units.
struct Shape {
  enum class Kind { none, primitive, mesh, plane, heights };
  Kind kind = Kind::none;
  contact::Primitive primitive{};
  Vec3 size{};          ///< plane: its normal; heights: extents along x and y, and the height of the number 1 (m)
  std::string mesh{};   ///< a file, relative to the folder of the file that names it
  Vec3 scale{1, 1, 1};  ///< of a mesh
  double split = 0;     ///< of a mesh that touches: the concavity of its convex parts (mesh/split.hpp); 0: its hull touches
  /// of a mesh: how it can be read (mesh/source.hpp); null if it does not exist, or if no files are accessed
  std::shared_ptr<const MeshSource> source{};
  std::shared_ptr<const HeightGrid> heights{};  ///< centred at the shape's origin
  Pose at{};                                    ///< placement of the shape's centre in the body's frame
  std::string colour{};                         ///< as CSS writes it, "#rrggbb" or a name; empty: the colour of the mechanism
  std::vector<Shape> more{};                    ///< further shapes of the same body
  bool part = false;                            ///< in a list by collider: a further part of the mesh before it

  static Shape of(contact::Primitive primitive, const Pose& at = {}) {
    return {.kind = Kind::primitive, .primitive = std::move(primitive), .at = at};
  }
  /// Null if it is not such a primitive.
  template <class P>
  const P* as() const {
    return kind == Kind::primitive ? std::get_if<P>(&primitive) : nullptr;
  }
};

/// Only the ground can have it.
inline bool is_of_ground(Shape::Kind kind) { return kind == Shape::Kind::plane || kind == Shape::Kind::heights; }

/// "#rrggbb" for red, green and blue from 0 to 1.
std::string colour_text(const std::vector<double>& rgb);

}  // namespace momentree::io
