#pragma once
// Parts of a model as a scenario would say them: tables of a document, without what is a default. Internal to the writers.
#include <span>
#include <string>
#include <vector>

#include <momentree/io/convert/pieces.hpp>
#include <momentree/io/shape.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/tree/model.hpp>

namespace momentree::io {

/// Geometry, start and parameters. `name`: empty where it is the body's; `parent`: a bare name, empty for the ground.
Value::Table describe_joint(const BodySpec& spec, const std::string& name, const std::string& parent);
Value describe_signal(const Signal& signal);

/// What is left out of a text, said once at the end.
struct LeftOut {
  int meshes = 0;  ///< not below the folder of the file that is written, or not there
  int flat = 0;    ///< shapes of which an edge, a radius or a length is zero
};

/// Where a mesh stands: its path is relative to `from`, what is written to `to`; empty: it stays as it is.
struct MeshFolders {
  std::string from, to;
};
/// Empty where the mesh is none of the files in `to` or below it.
std::string mesh_path(const std::string& mesh, const MeshFolders& folders);

/// A table, or a list of them where the body has several shapes; an empty table for none.
Value describe_shape(const Shape& shape, const MeshFolders& folders, LeftOut& left_out);

/// A whole mechanism, from the bodies of that prefix. `state`: a document that its joints start from; empty: none.
Value::Table describe_mechanism(const std::string& name, const Model& model, std::span<const int> bodies,
                                std::span<const Shape> shapes, const MeshFolders& folders, const std::string& state,
                                LeftOut& left_out);
Value::Table describe_force(const BodyForce& force, const Model& model);

}  // namespace momentree::io
