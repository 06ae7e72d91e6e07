// Springs between two points of bodies.
#include "members.hpp"
#include "model_object.hpp"
#include "world_object.hpp"

namespace momentree::python {

namespace {

/// A spring of a world: springs keep their numbers.
struct SpringObject {
  WorldPtr world;
  SpringId id;
};

template <class Get>
auto of_spring(Get get) {
  return [get](const SpringObject& spring) {
    const Reading world(spring.world);
    return get(world->spring(spring.id));
  };
}

nb::tuple end_of(const World& world, const SpringEnd& end) {
  return nb::make_tuple(end.body == ground ? std::string("ground") : world.model()[end.body].name, from_vec3(end.point));
}

std::vector<std::string> spring_names(const Model& model) {
  std::vector<std::string> names;
  for (const Spring& spring : model.springs()) names.push_back(spring.name);
  return names;
}

}  // namespace

void add_element(ModelObject& self, const std::string& kind, const std::string& name, nb::handle fields) {
  const std::string call = "Model.add_" + kind + (name.empty() ? "" : "('" + name + "')");
  io::PartReader(call).add_element(kind, name, to_value(fields, call), self.model);
}

void register_spring(nb::module_& m) {
  nb::class_<SpringObject> type(m, "Spring", "A spring or a cable between two points of bodies of a world. Arrays are copies.");
  add_members<SpringLaw>(type, of_spring([](const SpringView& s) { return s.law; }));
  type.def_prop_ro("name", of_spring([](const SpringView& s) { return std::string(s.name); }), "Name.")
      .def_prop_ro(
          "start",
          [](const SpringObject& s) {
            const Reading world(s.world);
            return end_of(*world, world->spring(s.id).from);
          },
          "Its first end: name of the body, or \"ground\", and the point in the body's frame (m), shape (3,).")
      .def_prop_ro(
          "end",
          [](const SpringObject& s) {
            const Reading world(s.world);
            return end_of(*world, world->spring(s.id).to);
          },
          "Its second end, in the same way: body, and point (m), shape (3,).")
      .def_prop_ro("length", of_spring([](const SpringView& s) { return s.length; }), "Distance between its ends (m).")
      .def_prop_ro("rate", of_spring([](const SpringView& s) { return s.rate; }), "Rate of the length (m/s).")
      .def_prop_ro("tension", of_spring([](const SpringView& s) { return s.tension; }),
                   "Force with which it pulls its ends together (N); negative: it pushes them apart. Zero once it is broken.")
      .def_prop_ro("broken", of_spring([](const SpringView& s) { return s.broken; }),
                   "True once it broke, or a body at one of its ends was removed.")
      .def_prop_ro("inextensible", of_spring([](const SpringView& s) { return s.inextensible; }),
                   "True for a cable, whose length never exceeds `rest`.")
      .def("__repr__", of_spring([](const SpringView& s) {
             return "<momentree.Spring '" + std::string(s.name) + (s.broken ? "', broken>" : "'>");
           }))
      .def("__eq__",
           [](const SpringObject& a, nb::handle other) {
             if (!nb::isinstance<SpringObject>(other)) return false;
             const auto& b = nb::cast<const SpringObject&>(other);
             return a.world->simulation == b.world->simulation && a.id == b.id;
           })
      .def("__hash__", [](const SpringObject& s) {
        return std::hash<const void*>{}(s.world->simulation.get()) ^ (static_cast<std::size_t>(s.id.index) << 2U);
      });
}

void add_springs_to(nb::class_<WorldObject>& type) {
  type.def_prop_ro(
          "springs", [](const WorldPtr& w) { return python_class("_world", "Springs")(w); },
          "The springs between points of bodies, by name: a mapping. Those that are broken stay in it.")
      .def("_spring",
           [](const WorldPtr& w, const std::string& name) {
             const Reading world(w);
             return SpringObject{w, world->model().spring(name)};
           })
      .def("_spring_names", [](const WorldPtr& w) { return spring_names(Reading(w)->model()); });
}

}  // namespace momentree::python
