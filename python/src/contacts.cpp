// What bodies of a model touch with, as values that can be pickled.
#include <memory>
#include <span>
#include <vector>

#include <momentree/contact/shapes/height_field.hpp>

#include "model_object.hpp"

namespace momentree::python {

namespace {

// Exact copies as tuples of numbers, for pickling.
nb::tuple from_vec(const Vec3& v) { return nb::make_tuple(v.x, v.y, v.z); }
Vec3 vec_from(nb::handle value) { return {nb::cast<double>(value[0]), nb::cast<double>(value[1]), nb::cast<double>(value[2])}; }
nb::list from_vecs(std::span<const Vec3> all) {
  nb::list list;
  for (const Vec3& v : all) list.append(from_vec(v));
  return list;
}
std::vector<Vec3> vecs_from(nb::handle value) {
  std::vector<Vec3> all;
  for (nb::handle each : value) all.push_back(vec_from(each));
  return all;
}

nb::tuple from_solid(const contact::Solid& s) {
  nb::list edges, faces, along;
  for (const contact::Solid::Edge& e : s.edges) edges.append(nb::make_tuple(e.ends[0], e.ends[1], e.faces[0], e.faces[1]));
  for (const contact::Solid::Face& f : s.faces) faces.append(nb::make_tuple(from_vec(f.normal), f.offset, f.corners, f.plane));
  for (const std::vector<Vec3>& each : s.along) along.append(from_vecs(each));
  return nb::make_tuple(from_vecs(s.vertices), edges, faces, along, s.radius, from_vec(s.centre), s.reach, s.thickness, s.rim,
                        from_vecs(s.ends), from_vec(s.belt), from_vecs(s.axes), s.surface);
}
contact::Solid solid_from(nb::handle value) {
  contact::Solid s;
  s.vertices = vecs_from(value[0]);
  for (nb::handle each : value[1]) {
    const auto number = [&each](int k) { return nb::cast<int>(each[k]); };
    s.edges.push_back({{number(0), number(1)}, {number(2), number(3)}});
  }
  for (nb::handle each : value[2])
    s.faces.push_back(
        {vec_from(each[0]), nb::cast<double>(each[1]), nb::cast<std::vector<int>>(each[2]), nb::cast<int>(each[3])});
  for (nb::handle each : value[3]) s.along.push_back(vecs_from(each));
  s.radius = nb::cast<double>(value[4]), s.centre = vec_from(value[5]);
  s.reach = nb::cast<double>(value[6]), s.thickness = nb::cast<double>(value[7]), s.rim = nb::cast<double>(value[8]);
  const std::vector<Vec3> ends = vecs_from(value[9]);
  s.ends = {ends.at(0), ends.at(1)}, s.belt = vec_from(value[10]);
  const std::vector<Vec3> axes = vecs_from(value[11]);
  s.axes = {axes.at(0), axes.at(1), axes.at(2)};
  s.surface = nb::cast<unsigned char>(value[12]);
  return s;
}

nb::object from_field(const std::shared_ptr<const contact::HeightField>& field) {
  if (!field) return nb::none();
  const Quat& r = field->at.rotation;
  return nb::make_tuple(field->x, field->y, field->columns, field->rows, field->heights, from_vec(field->at.position),
                        nb::make_tuple(r.w, r.x, r.y, r.z));
}
std::shared_ptr<const contact::HeightField> field_from(nb::handle value) {
  if (value.is_none()) return nullptr;
  const auto part = [&value](int k) { return nb::cast<double>(value[6][k]); };
  return std::make_shared<const contact::HeightField>(contact::height_field(
      nb::cast<double>(value[0]), nb::cast<double>(value[1]), nb::cast<int>(value[2]), nb::cast<int>(value[3]),
      nb::cast<std::vector<double>>(value[4]), {vec_from(value[5]), {part(0), part(1), part(2), part(3)}}));
}

std::vector<int> numbers_of_bodies(const std::vector<BodyId>& bodies) {
  std::vector<int> all;
  for (const BodyId body : bodies) all.push_back(body.index);
  return all;
}
std::vector<BodyId> body_ids_from(nb::handle numbers) {
  std::vector<BodyId> all;
  for (const int number : nb::cast<std::vector<int>>(numbers)) all.push_back({number});
  return all;
}

nb::tuple contact_state(const ModelObject& self) {
  nb::list colliders, rules;
  for (const Collider& c : self.model.colliders())
    colliders.append(
        nb::make_tuple(c.body.index, c.plane, from_vec(c.point), from_vec(c.normal), from_solid(c.solid), from_field(c.field)));
  for (const ContactRule& r : self.model.contact_rules())
    rules.append(nb::make_tuple(r.name, numbers_of_bodies(r.one), numbers_of_bodies(r.other), r.law.friction,
                                r.law.static_friction, r.law.restitution, r.law.off, r.one_name, r.other_name, r.law.torsional,
                                r.law.rolling));
  nb::list meshes;  // those of collision shapes, by collider
  for (std::size_t i = 0; i < self.collision_shapes.size(); ++i) {
    const io::Shape& shape = self.collision_shapes[i];
    const Quat& r = shape.at.rotation;
    if (shape.kind == io::Shape::Kind::mesh || shape.part)
      meshes.append(nb::make_tuple(i, shape.mesh, from_vec(shape.scale), from_vec(shape.at.position),
                                   nb::make_tuple(r.w, r.x, r.y, r.z), shape.split, shape.part));
  }
  return nb::make_tuple(colliders, rules, meshes);
}

void set_contact_state(ModelObject& self, nb::handle state) {
  for (nb::handle each : state[0])
    self.model.add_collider({.body = {nb::cast<int>(each[0])},
                             .solid = solid_from(each[4]),
                             .plane = nb::cast<bool>(each[1]),
                             .point = vec_from(each[2]),
                             .normal = vec_from(each[3]),
                             .field = field_from(each[5])});
  self.collision_shapes.resize(self.model.colliders().size());
  for (nb::handle each : state[2]) {
    io::Shape& shape = self.collision_shapes.at(nb::cast<std::size_t>(each[0]));
    const auto part = [&each](int k) { return nb::cast<double>(each[4][k]); };
    shape.split = nb::cast<double>(each[5]), shape.part = nb::cast<bool>(each[6]);
    if (!shape.part) shape.kind = io::Shape::Kind::mesh;
    shape.mesh = nb::cast<std::string>(each[1]), shape.scale = vec_from(each[2]);
    shape.at = {vec_from(each[3]), {part(0), part(1), part(2), part(3)}};
  }
  for (nb::handle each : state[1])
    self.model.add_contact_rule({.name = nb::cast<std::string>(each[0]),
                                 .one = body_ids_from(each[1]),
                                 .other = body_ids_from(each[2]),
                                 .law = {.friction = nb::cast<double>(each[3]),
                                         .static_friction = nb::cast<double>(each[4]),
                                         .torsional = nb::cast<double>(each[9]),
                                         .rolling = nb::cast<double>(each[10]),
                                         .restitution = nb::cast<double>(each[5]),
                                         .off = nb::cast<bool>(each[6])},
                                 .one_name = nb::cast<std::string>(each[7]),
                                 .other_name = nb::cast<std::string>(each[8])});
}

}  // namespace

void add_contacts_to(nb::class_<ModelObject>& type) {
  type.def("_contact_state", &contact_state).def("_set_contact_state", &set_contact_state);
}

}  // namespace momentree::python
