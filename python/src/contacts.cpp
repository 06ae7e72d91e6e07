// What bodies of a model touch with, as bytes for pickling.
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/checkpoint/model_fields.hpp>

#include "model_object.hpp"

namespace momentree::python {

namespace {

constexpr io::CheckpointWords pickled_model{"this pickle", "pickle the model again",
                                            "unpickle it with the version that wrote it"};

// The mesh of a collision shape.
struct TouchingMesh {
  std::size_t collider = 0;
  std::string mesh;
  Vec3 scale{};
  Pose at{};
  double split = 0;
  bool part = false;
};
template <class Archive>
void fields(Archive& archive, io::Part<Archive, TouchingMesh>& m) {
  archive(m.collider, m.mesh, m.scale, m.at, m.split, m.part);
}

nb::bytes contact_state(const ModelObject& self) {
  std::vector<TouchingMesh> meshes;
  for (std::size_t i = 0; i < self.collision_shapes.size(); ++i) {
    const io::Shape& shape = self.collision_shapes[i];
    if (shape.kind == io::Shape::Kind::mesh || shape.part)
      meshes.push_back({i, shape.mesh, shape.scale, shape.at, shape.split, shape.part});
  }
  io::ArchiveWriter archive;
  archive(self.model.colliders(), self.model.contact_rules(), meshes);
  const std::string bytes = io::sealed(archive.bytes);
  return nb::bytes(bytes.data(), bytes.size());
}

void set_contact_state(ModelObject& self, const nb::bytes& state) {
  io::ArchiveReader archive(io::unsealed({state.c_str(), state.size()}, "pickle", pickled_model), "this pickle is damaged");
  std::vector<Collider> colliders;
  std::vector<ContactRule> rules;
  std::vector<TouchingMesh> meshes;
  archive(colliders, rules, meshes);
  for (Collider& collider : colliders) self.model.add_collider(std::move(collider));
  self.collision_shapes.resize(self.model.colliders().size());
  for (TouchingMesh& each : meshes) {
    io::Shape& shape = self.collision_shapes.at(each.collider);
    if (!each.part) shape.kind = io::Shape::Kind::mesh;
    shape.mesh = std::move(each.mesh), shape.scale = each.scale, shape.at = each.at;
    shape.split = each.split, shape.part = each.part;
  }
  for (ContactRule& rule : rules) self.model.add_contact_rule(std::move(rule));
}

}  // namespace

void add_contacts_to(nb::class_<ModelObject>& type) {
  type.def("_contact_state", &contact_state).def("_set_contact_state", &set_contact_state);
}

}  // namespace momentree::python
