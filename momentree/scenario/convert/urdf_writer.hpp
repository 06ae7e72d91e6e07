#pragma once
// Links and joints as URDF. Internal to the writers.
#include <string>
#include <vector>

#include <momentree/models/import/shape.hpp>
#include <momentree/scenario/convert/document_values.hpp>

namespace momentree::io::urdf {

struct WrittenLink {
  std::string name, comment;  ///< the comment may be empty
  double mass = 0;
  Vec3 com{};
  Sym3 inertia{};  ///< about the centre of mass, in the link's axes
  std::vector<Shape> shapes{};
};

struct WrittenJoint {
  std::string name, type, parent, child;
  Pose origin{};
  bool has_axis = false;
  Vec3 axis{};
  bool stops = false;  ///< whether `lower` and `upper` are the model's
  double lower = 0, upper = 0, effort = 0;
  double damping = 0, friction = 0;
};

/// Appends the XML element of a link or of a joint.
void write(std::string& text, const WrittenLink& link);
void write(std::string& text, const WrittenJoint& joint);
/// The text with XML's special characters escaped.
std::string escaped(const std::string& text);

}  // namespace momentree::io::urdf
