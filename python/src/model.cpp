// Model: bodies, joints, forces and springs, added one by one.
#include "model_object.hpp"

#include <tuple>
#include <utility>

#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/convert/scenario_names.hpp>
#include <momentree/scenario/part_reader.hpp>

namespace momentree::python {

std::shared_ptr<const io::Scenario> scenario_of(const ModelObject& model, const Integration& integration) {
  auto scenario = std::make_shared<io::Scenario>();
  scenario->name = "simulation";
  scenario->title = model.title;
  scenario->model = model.model;
  scenario->integration = integration;
  scenario->shapes = model.shapes;
  scenario->collision_shapes = model.collision_shapes;
  scenario->shapes.resize(static_cast<std::size_t>(model.model.size()));
  return scenario;
}

BodyId parent_in(const ModelPtr& model, nb::handle parent) {
  if (parent.is_none()) return ground;
  if (nb::isinstance<ModelBody>(parent)) {
    const auto& body = nb::cast<const ModelBody&>(parent);
    if (body.model != model) refuse("the parent is a body of another model", "use its name");
    return body.id;
  }
  std::string name;
  if (!nb::try_cast(parent, name)) refuse("parent: expected None, a name, or a body of this model");
  return name == "ground" ? ground : model->model.body(name);
}

io::BodyPart body_part(const std::string& call, const std::string& name, nb::handle fields) {
  return io::PartReader(call).body(name, to_value(fields, call));
}

namespace {

std::string call_of(const char* what, const std::string& name) { return std::string(what) + "('" + name + "')"; }

ModelBody add(const ModelPtr& self, const std::string& name, nb::handle parent, nb::handle fields) {
  const std::string call = call_of("Model.add", name);
  io::BodyPart part = body_part(call, name, fields);
  part.spec.parent = parent_in(self, parent);
  const BodyId body = self->model.add(std::move(part.spec));
  self->shapes.resize(static_cast<std::size_t>(self->model.size()));
  self->shapes.back() = std::move(part.shape);
  for (contact::Solid& solid : part.solids) self->model.add_collider({.body = body, .solid = std::move(solid)});
  io::note_collision_shapes(self->model, std::move(part.collision_shapes), self->collision_shapes);
  return {self, body};
}

void add_floor(ModelObject& self, nb::handle fields) {
  io::PartReader("Model.add_floor").add_floor(to_value(fields, "Model.add_floor"), self.model);
}

void add_ground(ModelObject& self, nb::handle collision) {
  io::PartReader("Model.add_ground").add_ground(to_value(collision, "Model.add_ground"), self.model, self.collision_shapes);
}

void add_contact(ModelObject& self, nb::handle fields) {
  io::PartReader("Model.add_contact").add_contact(to_value(fields, "Model.add_contact"), self.model);
}

void add_force(ModelObject& self, const std::string& body, nb::handle fields) {
  const std::string call = call_of("Model.add_force", body);
  for (BodyForce& force : io::PartReader(call).forces(to_value(fields, call), self.model)) self.model.add_force(std::move(force));
}

void add_loop(const ModelPtr& self, const std::string& name, nb::handle body, nb::handle to, nb::handle fields) {
  const std::string call = call_of("Model.add_loop", name);
  Value table = to_value(fields, call);
  const auto end = [&](const char* key, nb::handle of) {
    const BodyId id = parent_in(self, of);
    const std::string text = self->model.body_name(id);
    table.table()->insert(table.table()->begin(), Value::Entry{key, table.place, Value(text, table.place)});
  };
  if (!to.is_none()) end("to", to);
  end("body", body);
  self->model.add_loop(io::PartReader(call).loop(name, table, self->model));
}

template <class Name>
std::vector<std::string> names(const ModelObject& self, Name name) {
  std::vector<std::string> all;
  for (const BodySpec& body : self.model.bodies()) all.push_back(name(body));
  return all;
}

// The same model without what touches, with its bodies in another order, parents before children: of scenarios, which list
// mechanism by mechanism. `names`: of bodies and joints in that order, which scenarios may have changed.
std::shared_ptr<ModelObject> in_order(const ModelObject& self, const std::vector<std::string>& order,
                                      const std::vector<std::pair<std::string, std::string>>& names) {
  auto sorted = std::make_shared<ModelObject>(ModelObject{Model({.gravity = self.model.gravity()}), {}, self.title});
  std::vector<BodyId> place(static_cast<std::size_t>(self.model.size()), ground);
  const auto now = [&](int number) { return number < 0 ? ground : place[static_cast<std::size_t>(number)]; };
  for (const std::string& name : order) {
    const BodyId body = self.model.body(name);
    BodySpec spec = self.model[body];
    spec.parent = now(spec.parent.index);
    std::tie(spec.name, spec.joint_name) = names.at(static_cast<std::size_t>(sorted->model.size()));
    place[static_cast<std::size_t>(body.index)] = sorted->model.add_unjudged(std::move(spec));
    sorted->shapes.push_back(self.shapes[static_cast<std::size_t>(body.index)]);
  }
  for (BodyForce force : self.model.forces()) {
    force.body = now(force.body.index);
    sorted->model.add_force(std::move(force));
  }
  for (Spring spring : self.model.springs()) {
    for (SpringEnd* end : {&spring.from, &spring.to}) end->body = now(end->body.index);
    sorted->model.add_spring(std::move(spring));
  }
  for (LoopSpec loop : self.model.loops()) {
    loop.body = now(loop.body.index), loop.to = now(loop.to.index);
    sorted->model.add_loop(std::move(loop));
  }
  for (Coupling coupling : self.model.couplings()) {
    coupling.joint = {now(coupling.joint.index).index}, coupling.follows = {now(coupling.follows.index).index};
    sorted->model.add_coupling(coupling);
  }
  for (const JointElement& element : self.model.elements())
    sorted->model.add_element(with_joints(element, [&now](JointId joint) { return JointId{now(joint.index).index}; }));
  return sorted;
}

std::string to_urdf(const ModelObject& self, const std::string& mechanism) {
  return io::to_urdf(*scenario_of(self, {}), mechanism, "").text;
}

}  // namespace

void register_model(nb::module_& m) {
  nb::class_<ModelBody>(m, "ModelBody",
                        "A body of a model, to be the parent of others; `Model.add` returns it. It may be given wherever a "
                        "body's name is expected.")
      .def_prop_ro(
          "name", [](const ModelBody& b) { return b.model->model[b.id].name; }, "Name: \"mechanism/body\".")
      .def_prop_ro(
          "index", [](const ModelBody& b) { return b.id.index; },
          "Number of the body and of its joint, in the order of adding, from 0.")
      .def("__repr__", [](const ModelBody& b) { return "<momentree.ModelBody '" + b.model->model[b.id].name + "'>"; });
  nb::class_<ModelObject> model(m, "ModelBase");
  add_contacts_to(model);
  model.def("__init__", [](ModelObject* self, const ModelObject& other) { new (self) ModelObject(other); })
      .def(
          "__init__",
          [](ModelObject* self, nb::handle gravity) {
            const Vec3 g = to_vec3(gravity, "gravity");
            new (self) ModelObject{Model({.gravity = g}), {}};
          },
          "gravity"_a)
      .def("_add", &add, "name"_a, "parent"_a.none(), "fields"_a)
      .def("_add_loop", &add_loop, nb::arg(), nb::arg().none(), nb::arg().none(), nb::arg())
      .def("_add_floor", &add_floor)
      .def("_add_ground", &add_ground)
      .def("_add_contact", &add_contact)
      .def("_add_force", &add_force)
      .def("_add_element", &add_element)
      .def("__len__", [](const ModelObject& self) { return self.model.size(); })
      .def_prop_ro(
          "body_names", [](const ModelObject& self) { return names(self, [](const BodySpec& b) { return b.name; }); },
          "Names of the bodies, in the order of adding, a copy.")
      .def_prop_ro(
          "joint_names", [](const ModelObject& self) { return names(self, [](const BodySpec& b) { return b.joint_name; }); },
          "Names of the joints of bodies, in the order of adding, a copy.")
      .def_prop_ro(
          "spring_names",
          [](const ModelObject& self) {
            std::vector<std::string> all;
            for (const Spring& spring : self.model.springs()) all.push_back(spring.name);
            return all;
          },
          "Names of the springs, in the order of adding, a copy.")
      .def_prop_ro(
          "loop_names",
          [](const ModelObject& self) {
            std::vector<std::string> all;
            for (const LoopSpec& loop : self.model.loops()) all.push_back(loop.name);
            return all;
          },
          "Names of the joints that close loops, in the order of adding, a copy.")
      .def_prop_rw(
          "gravity", [](const ModelObject& self) { return from_vec3(self.model.gravity()); },
          [](ModelObject& self, nb::handle gravity) { self.model.set_gravity(to_vec3(gravity, "gravity")); }, nb::arg().none(),
          "Gravity (m/s²), world axes, shape (3,), a copy; assign three numbers to change it.")
      .def("_in_order", &in_order)
      .def("_scenario_names",
           [](const ModelObject& self) {
             std::vector<std::string> bodies;
             for (const io::ScenarioName& name : io::scenario_names(self.model)) bodies.push_back(name.body);
             return bodies;
           })
      .def(
          "to_toml", [](const ModelObject& self) { return io::to_toml(self.model, self.shapes, true, self.collision_shapes); },
          "The model as the text of a scenario file (TOML), without events. `momentree.loads` reads it.\n\n"
          "Names that do not begin with the mechanism of their root get it in front, with dots for slashes: `hand`, carried\n"
          "by `arm`, becomes `arm/hand`, and `gripper/base` becomes `arm/gripper.base`.\n\n"
          "Raises:\n    Error: A body touches with a mesh of a model file.")
      .def("_to_toml_without_contact", [](const ModelObject& self) { return io::to_toml(self.model, self.shapes, false); })
      .def("to_urdf", &to_urdf, "mechanism"_a = "",
           "One mechanism as the text of a URDF file.\n\n"
           "Args:\n    mechanism: Its name; may be left out if there is only one.\n\n"
           "Raises:\n    Error: URDF cannot express it, or there is no such mechanism.");
}

}  // namespace momentree::python
