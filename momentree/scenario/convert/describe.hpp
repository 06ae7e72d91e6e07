#pragma once
// Parts of a model as tables of a scenario document; default values are omitted. Internal to the writers.
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/joint/motion.hpp>
#include <momentree/model/model.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/scenario/convert/document_values.hpp>

namespace momentree::io {

/// Geometry, initial values and parameters. `name`: empty if it is the body's name; `parent`: a bare name, empty for the
/// ground.
Value::Table describe_joint(const BodySpec& spec, const std::string& name, const std::string& parent);
Value describe_signal(const Signal& signal);

/// Counts of what is left out of a text; reported once at the end.
struct LeftOut {
  int meshes = 0;     ///< meshes that do not exist, or are not below the folder of the file that is written
  int flat = 0;       ///< shapes with an edge, radius or length of zero
  int colliders = 0;  ///< collision elements of model files
};

/// Names of meshes in a text whose reader has the meshes themselves, by the keys of their sources (mesh/source.hpp).
using MeshNames = std::unordered_map<std::string, std::string>;

/// The folders for mesh paths: they are given relative to `from` and written relative to `to`; if `to` is empty, they stay
/// unchanged. With `names`, meshes get these instead.
struct MeshFolders {
  std::string from, to;
  const MeshNames* names = nullptr;
};
/// Empty if the mesh is not a file in `to` or below it.
std::string mesh_path(const std::string& mesh, const MeshFolders& folders);

/// A table, or a list of tables if the body has several shapes; an empty table if it has none.
Value describe_shape(const Shape& shape, const MeshFolders& folders, LeftOut& left_out);

/// A whole mechanism, from its bodies. `state`: a document that its joints start from; empty: none.
Value::Table describe_mechanism(const std::string& name, const Model& model, std::span<const int> bodies,
                                std::span<const Shape> shapes, const MeshFolders& folders, const std::string& state,
                                LeftOut& left_out);
/// What a body, or the ground without its floor, touches with, a list; the floor, or an empty table; and the
/// [[contact]] tables: one for each pair of bodies that has a law. Throws Error for what a scenario can only name by a file, or
/// not at all.
Value describe_collision(const Model& model, BodyId body, const std::vector<Shape>& collision_shapes);
/// Of its colliders; an empty table if their surfaces do not run.
Value::Table describe_belt(const Model& model, BodyId body);
Value::Table describe_floor(const Model& model);
Value describe_contacts(const Model& model);
Value::Table describe_force(const BodyForce& force, const Model& model);
Value::Table describe_spring(const Spring& spring, const Model& model);
/// The tables of the couplings of a model: those by springs, then the exact ones.
Value::Array describe_couplings(const Model& model);
/// The tables of each kind of element between joints that has tables of its own, by their key.
std::vector<std::pair<const char*, Value::Array>> describe_elements(const Model& model);
Value::Table describe_loop(const LoopSpec& loop, const Model& model);

}  // namespace momentree::io
