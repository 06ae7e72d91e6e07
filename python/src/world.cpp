// World, Body, Joint and Context.
#include <algorithm>

#include "model_object.hpp"
#include "records.hpp"
#include "world_object.hpp"

#include <momentree/topology/change.hpp>

namespace momentree::python {

Reading::Reading(const WorldPtr& world) {
  if (!world->is_passed) {
    use_.emplace(*world->simulation, Access::read);
    world_ = &world->simulation->simulation().world();
  } else {
    world_ = world->passed;
    if (world_ == nullptr)
      refuse("this world was passed to a function and is no longer valid",
             "read what is needed during the call, or use sim.world");
  }
}

nb::object name_of(nb::handle handle) {
  if (nb::isinstance<BodyObject>(handle) || nb::isinstance<JointObject>(handle)) return handle.attr("name");
  return nb::borrow(handle);
}

namespace {

std::vector<std::string> body_names(const World& world) {
  std::vector<std::string> names;
  for (int b = 0; b < world.model().size(); ++b)
    if (world.alive({b})) names.push_back(world.model()[BodyId{b}].name);
  return names;
}

std::vector<std::string> joint_names(const World& world) {
  std::vector<std::string> names;
  for (int b = 0; b < world.model().size(); ++b)
    if (world.tree().carrier(b) >= 0) names.emplace_back(world.joint_name({b}));
  for (const JointId loop : world.loops()) names.emplace_back(world.joint_name(loop));
  return names;
}

std::vector<std::string> loop_names(const World& world) {
  std::vector<std::string> names;
  for (const JointId loop : world.loops()) names.emplace_back(world.joint_name(loop));
  return names;
}

void check_owner(const WorldPtr& world, const SimulationObject& object) {
  if (world->simulation.get() != &object)
    refuse("the handle belongs to another simulation", "use the name, or the handle of this simulation");
}

bool is_body(const World& world, int number, const std::string& name) {
  return number < world.model().size() && world.model()[BodyId{number}].name == name;
}

void check_body_exists(const World& world, const BodyObject& body) {
  if (!is_body(world, body.id.index, body.name))
    refuse("there is no body '" + body.name + "' in the state that was restored", "it was added afterwards");
}

bool is_present_loop(const World& world, const JointObject& joint) {
  return world.tree().loops().find(joint.id) != nullptr && world.joint_name(joint.id) == joint.body;
}

// The joint of a handle at present: a loop joint that took the place of a broken joint has another number.
JointId present_joint(const World& world, const JointObject& joint) {
  if (!is_loop(joint.id) || is_present_loop(world, joint)) return joint.id;
  const int number = world.find_joint(joint.body);
  if (number < 0) refuse("the joint '" + joint.body + "' no longer exists", "world.joints lists the present ones");
  return {number};
}

void check_joint_exists(const World& world, const JointObject& joint) {
  if (is_loop(joint.id)) return;  // present_joint looks for it
  if (!is_body(world, joint.id.index, joint.body))
    refuse("there is no joint of '" + joint.body + "' in the state that was restored", "it was added afterwards");
  if (world.tree().carrier(joint.id.index) < 0) refuse("the joint of this handle was removed with its body");
}

std::string text_of(nb::handle name, const char* what) {
  if (nb::isinstance<ModelBody>(name)) {
    const auto& body = nb::cast<const ModelBody&>(name);
    return body.model->model[body.id].name;
  }
  std::string text;
  if (!nb::try_cast(name, text)) refuse(std::string("expected the name of a ") + what);
  return text;
}

BodyId find_body(const World& world, const std::string& name) {
  if (!world.model().has_body(name)) refuse("there is no body '" + name + "'", did_you_mean(name, body_names(world)));
  const BodyId body = world.model().body(name);
  if (!world.alive(body)) refuse("the body '" + name + "' was removed");
  return body;
}

JointId find_joint(const World& world, const std::string& name) {
  const int number = world.find_joint(name);
  if (number >= 0) return {number};
  const bool was = world.model().has_joint(name);
  refuse(was ? "the joint '" + name + "' no longer exists" : "there is no joint '" + name + "'",
         was ? "world.joints lists the present ones" : did_you_mean(name, joint_names(world)));
}

}  // namespace

BodyId body_of(const World& world, const SimulationObject& object, nb::handle name) {
  if (nb::isinstance<BodyObject>(name)) {
    const auto& handle = nb::cast<const BodyObject&>(name);
    check_owner(handle.world, object);
    check_body_exists(world, handle);
    return find_body(world, handle.name);
  }
  return find_body(world, text_of(name, "body"));
}

JointId joint_of(const World& world, const SimulationObject& object, nb::handle name) {
  if (nb::isinstance<JointObject>(name)) {
    const auto& handle = nb::cast<const JointObject&>(name);
    check_owner(handle.world, object);
    check_joint_exists(world, handle);
    return present_joint(world, handle);
  }
  return find_joint(world, text_of(name, "joint"));
}

namespace {

const BodyMotion& motion_of(const World& world, BodyId body) {
  if (!world.alive(body)) refuse("the body '" + world.model()[body].name + "' was removed");
  return world.motions()[static_cast<std::size_t>(body.index)];
}

Mat3 rotation_of(const World& world, BodyId body) { return rotation_matrix(motion_of(world, body).pose.rotation); }

nb::object from_matrix(const Mat3& m) {
  NewArray array = new_array(3, 3);
  const double numbers[] = {m.xx, m.xy, m.xz, m.yx, m.yy, m.yz, m.zx, m.zy, m.zz};
  std::ranges::copy(numbers, array.data);
  return std::move(array.object);
}

const BodyAcceleration& acceleration_of(const World& world, BodyId body) {
  (void)motion_of(world, body);
  return world.accelerations()[static_cast<std::size_t>(body.index)];
}

nb::object wrench(const Wrench& w) { return python_class("_records", "Wrench")(from_vec3(w.force), from_vec3(w.torque)); }

nb::object energy(const Totals& totals) { return python_class("_records", "Energy")(totals.kinetic, totals.potential); }

nb::object momentum(const Totals& totals) {
  return python_class("_records", "Momentum")(from_vec3(totals.linear), from_vec3(totals.angular));
}

// An array that is a copy can't be written: that would have no effect, and must not look as if it had.
template <class Value>
Value fixed(Value value) {
  if constexpr (std::is_same_v<Value, nb::object>)
    if (nb::hasattr(value, "setflags")) value.attr("setflags")(false);
  return value;
}

// A property of a body that is computed from the world.
template <class Get>
auto of_body(Get get) {
  return [get](const BodyObject& body) {
    const Reading world(body.world);
    check_body_exists(*world, body);
    return fixed(get(*world, body.id));
  };
}

template <class Get>
auto of_joint(Get get) {
  return [get](const JointObject& joint) {
    const Reading world(joint.world);
    check_joint_exists(*world, joint);
    return fixed(get(*world, present_joint(*world, joint)));
  };
}

nb::object mechanism_of(const World& world, BodyId body) {
  (void)motion_of(world, body);
  return nb::str(std::string(world.mechanism_name(root_of(world.tree(), body))).c_str());
}

nb::object parent_of(const World& world, JointId joint) {
  const JointView view = world.joint(joint);
  if (view.parent.index < 0) return nb::str("ground");
  return nb::str(world.model()[view.parent].name.c_str());
}

void register_body(nb::module_& m) {
  nb::class_<BodyObject>(
      m, "Body",
      "A body of a world. Handles stay valid through every change of topology. Arrays are copies and can't be written. `==` "
      "compares bodies.")
      .def_prop_ro(
          "name", [](const BodyObject& b) { return b.name; }, "Name: \"mechanism/body\".")
      .def_prop_ro(
          "index", [](const BodyObject& b) { return b.id.index; }, "Number of the body, in the order of adding, from 0.")
      .def_prop_ro(
          "alive",
          [](const BodyObject& b) {
            const Reading world(b.world);
            return is_body(*world, b.id.index, b.name) && world->alive(b.id);
          },
          "False for a removed body.")
      .def_prop_ro("mass", of_body([](const World& w, BodyId b) { return w.model()[b].mass; }), "Mass (kg).")
      .def_prop_ro("com", of_body([](const World& w, BodyId b) { return from_vec3(w.model()[b].com); }),
                   "Centre of mass in the body's frame (m), shape (3,).")
      .def_prop_ro("position", of_body([](const World& w, BodyId b) { return from_vec3(motion_of(w, b).pose.position); }),
                   "Origin of the body's frame in the world (m), shape (3,).")
      .def_prop_ro("quaternion", of_body([](const World& w, BodyId b) { return from_quat(motion_of(w, b).pose.rotation); }),
                   "Orientation of the body's frame in the world, unit quaternion (w, x, y, z), shape (4,).")
      .def_prop_ro("rotation", of_body([](const World& w, BodyId b) { return from_matrix(rotation_of(w, b)); }),
                   "Rotation matrix from the body's axes to those of the world, shape (3, 3).")
      .def_prop_ro("com_position",
                   of_body([](const World& w, BodyId b) { return from_vec3(motion_of(w, b).pose * w.model()[b].com); }),
                   "Centre of mass in the world (m), shape (3,).")
      .def_prop_ro("com_velocity", of_body([](const World& w, BodyId b) {
                     const BodyMotion& motion = motion_of(w, b);
                     return from_vec3(motion.linear + cross(motion.angular, rotation_of(w, b) * w.model()[b].com));
                   }),
                   "Velocity of the centre of mass (m/s), world axes, shape (3,).")
      .def_prop_ro("inertia", of_body([](const World& w, BodyId b) {
                     const Sym3 turned = rotate(rotation_of(w, b), w.model()[b].inertia);
                     return from_matrix(
                         {turned.xx, turned.xy, turned.xz, turned.xy, turned.yy, turned.yz, turned.xz, turned.yz, turned.zz});
                   }),
                   "Inertia about the centre of mass (kg m²), world axes, shape (3, 3).")
      .def_prop_ro("linear", of_body([](const World& w, BodyId b) { return from_vec3(motion_of(w, b).linear); }),
                   "Velocity of the frame's origin (m/s), world axes, shape (3,).")
      .def_prop_ro("angular", of_body([](const World& w, BodyId b) { return from_vec3(motion_of(w, b).angular); }),
                   "Angular velocity (rad/s), world axes, shape (3,).")
      .def_prop_ro("linear_acceleration",
                   of_body([](const World& w, BodyId b) { return from_vec3(acceleration_of(w, b).linear); }),
                   "Time derivative of `linear` (m/s²), world axes, shape (3,).")
      .def_prop_ro("angular_acceleration",
                   of_body([](const World& w, BodyId b) { return from_vec3(acceleration_of(w, b).angular); }),
                   "Time derivative of `angular` (rad/s²), world axes, shape (3,).")
      .def_prop_ro("mechanism", of_body(mechanism_of), "Name of the mechanism that the body belongs to at present.")
      .def("__repr__", [](const BodyObject& b) { return "<momentree.Body '" + b.name + "'>"; })
      .def("__eq__",
           [](const BodyObject& a, nb::handle other) {
             if (!nb::isinstance<BodyObject>(other)) return false;
             const auto& b = nb::cast<const BodyObject&>(other);
             return a.world->simulation == b.world->simulation && a.id == b.id && a.name == b.name;
           })
      .def("__hash__", [](const BodyObject& b) {
        return std::hash<const void*>{}(b.world->simulation.get()) ^ static_cast<std::size_t>(b.id.index);
      });
}

void register_joint(nb::module_& m) {
  nb::class_<JointObject>(
      m, "Joint",
      "A joint of a world: the same joint for as long as it exists, whichever body it carries. Arrays are copies and can't be "
      "written; `Simulation.q` and `Simulation.set_state` set the state.")
      .def_prop_ro("name", of_joint([](const World& w, JointId j) { return std::string(w.joint_name(j)); }),
                   "Name at present: after the joint broke, that of the body that broke off.")
      .def_prop_ro(
          "index", [](const JointObject& j) { return j.id.index; },
          "Number of the joint, that of the body it was added with, from 0; loop joints have other numbers, from 2**28 on.")
      .def_prop_ro("kind", of_joint([](const World& w, JointId j) { return std::string(info(w.joint(j).kind).name); }),
                   "Its kind at present: \"revolute\", \"free\" …")
      .def_prop_ro("parent", of_joint(parent_of), "Name of its declared parent, or \"ground\".")
      .def_prop_ro("child", of_joint([](const World& w, JointId j) { return w.model()[w.joint(j).child].name; }),
                   "Name of its declared child.")
      .def_prop_ro("q", of_joint([](const World& w, JointId j) { return copy_of(w.joint(j).q); }),
                   "Coordinates (rad, m, quaternions as w, x, y, z), shape (nq,), a copy.")
      .def_prop_ro("v", of_joint([](const World& w, JointId j) { return copy_of(w.joint(j).v); }),
                   "Velocities (rad/s, m/s), shape (nv,), a copy.")
      .def_prop_ro("p", of_joint([](const World& w, JointId j) { return copy_of(w.joint(j).p); }),
                   "Canonical momenta conjugate to v (N m s, N s), shape (nv,), a copy. Equation (19) of the paper.")
      .def_prop_ro("pdot", of_joint([](const World& w, JointId j) { return copy_of(w.joint(j).pdot); }),
                   "Time derivatives of p (N m, N), shape (nv,), a copy. Equation (20) of the paper.")
      .def_prop_ro("a", of_joint([](const World& w, JointId j) { return copy_of(w.joint_forces(j).a); }),
                   "Time derivatives of v (rad/s², m/s²), shape (nv,), a copy. Equations (30) to (51) of the paper.")
      .def_prop_ro(
          "reaction", of_joint([](const World& w, JointId j) { return wrench(w.joint_forces(j).reaction); }),
          "Wrench of the parent on the child through the joint, drive and spring included: about the origin of the joint's "
          "frame on the child (N, N m), in the child's axes, each of shape (3,). Equation (32) of the paper.")
      .def_prop_ro("bearing", of_joint([](const World& w, JointId j) { return wrench(w.joint_forces(j).bearing); }),
                   "The reaction without the effort along the joint's degrees of freedom: what its bearings and locks carry (N, "
                   "N m), each of "
                   "shape (3,).")
      .def_prop_ro("effort", of_joint([](const World& w, JointId j) {
                     const Values effort = w.joint_forces(j).effort;
                     return copy_of({effort.begin(), effort.end()});
                   }),
                   "Effort along each degree of freedom (N m, N), shape (nv,), a copy: drives, springs, dampers, friction.")
      .def_prop_ro("locked", of_joint([](const World& w, JointId j) {
                     const JointView view = w.joint(j);
                     nb::list dofs;
                     for (int i = 0; i < info(view.kind).nv; ++i)
                       if ((view.locked >> i & 1u) != 0) dofs.append(i);
                     return nb::tuple(dofs);
                   }),
                   "Indices of its locked degrees of freedom, in the order of v.")
      .def_prop_ro("loop", of_joint([](const World&, JointId j) { return is_loop(j); }),
                   "True if it closes a loop. Such a joint has no p, pdot and a of its own: shape (0,).")
      .def_prop_ro("determined", of_joint([](const World& w, JointId j) { return w.joint_forces(j).determined; }),
                   "False if the closed loops leave its reaction open. Other reactions then cause the same motion; `reaction` is "
                   "that of those for which the sum of squares over all joints is least.")
      .def("__repr__", of_joint([](const World& w, JointId j) {
             return "<momentree.Joint '" + std::string(w.joint_name(j)) + "', " + info(w.joint(j).kind).name + ">";
           }))
      .def("__eq__",
           [](const JointObject& a, nb::handle other) {
             if (!nb::isinstance<JointObject>(other)) return false;
             const auto& b = nb::cast<const JointObject&>(other);
             return a.world->simulation == b.world->simulation && a.id == b.id && a.body == b.body;
           })
      .def("__hash__", [](const JointObject& j) {
        return std::hash<const void*>{}(j.world->simulation.get()) ^ (static_cast<std::size_t>(j.id.index) << 1U);
      });
}

const EvaluationContext& context_of(const ContextObject& c) {
  if (c.context == nullptr)
    refuse("this context was passed to a function and is no longer valid", "read what is needed during the call");
  return *c.context;
}

// Within an evaluation the world's names may be read, but nothing else of it.
JointId context_joint(const ContextObject& c, nb::handle name) {
  (void)context_of(c);
  return joint_of(c.simulation->simulation().world(), *c.simulation, name);
}
BodyId context_body(const ContextObject& c, nb::handle name) {
  (void)context_of(c);
  if (!nb::isinstance<BodyObject>(name) && text_of(name, "body") == "ground") return ground;
  return body_of(c.simulation->simulation().world(), *c.simulation, name);
}

template <class Get>
auto of_motion(Get get) {
  return [get](const ContextObject& c, nb::handle body) { return get(context_of(c).motion(context_body(c, body))); };
}

void register_context(nb::module_& m) {
  nb::class_<ContextObject>(
      m, "Context",
      "What a function that drives a joint or acts on a body may read: the state at a stage of a step. Valid "
      "during the call.")
      .def_prop_ro(
          "time", [](const ContextObject& c) { return context_of(c).time(); }, "Time (s).")
      .def(
          "q", [](const ContextObject& c, nb::handle joint) { return copy_of(context_of(c).q(context_joint(c, joint))); },
          "joint"_a, "Coordinates of a joint (rad, m), shape (nq,).")
      .def(
          "v", [](const ContextObject& c, nb::handle joint) { return copy_of(context_of(c).v(context_joint(c, joint))); },
          "joint"_a, "Velocities of a joint (rad/s, m/s), shape (nv,).")
      .def("position", of_motion([](const BodyMotion& b) { return from_vec3(b.pose.position); }), "body"_a,
           "Origin of a body's frame (m), world axes, shape (3,).")
      .def("quaternion", of_motion([](const BodyMotion& b) { return from_quat(b.pose.rotation); }), "body"_a,
           "Orientation of a body's frame (w, x, y, z), shape (4,).")
      .def("linear", of_motion([](const BodyMotion& b) { return from_vec3(b.linear); }), "body"_a,
           "Velocity of the origin of a body's frame (m/s), world axes, shape (3,).")
      .def("angular", of_motion([](const BodyMotion& b) { return from_vec3(b.angular); }), "body"_a,
           "Angular velocity of a body (rad/s), world axes, shape (3,).");
}

nb::list mechanisms_of(const World& world) {
  const nb::object type = python_class("_records", "Mechanism");
  nb::list all;
  for (const Mechanism& each : world.mechanisms()) {
    nb::list bodies;
    for (const BodyId body : each.bodies) bodies.append(world.model()[body].name);
    all.append(type(std::string(each.name), world.model()[each.root].name, each.grounded, bodies));
  }
  return all;
}

}  // namespace

void register_world(nb::module_& m) {
  register_body(m);
  register_joint(m);
  register_context(m);
  register_spring(m);
  nb::class_<WorldObject> type(
      m, "World",
      "The world of a simulation at its present instant. One that was passed to a function is valid during the call.");
  add_springs_to(type);
  type.def_prop_ro(
          "time", [](const WorldPtr& w) { return Reading(w)->time(); }, "Time (s).")
      .def_prop_ro(
          "gravity", [](const WorldPtr& w) { return from_vec3(Reading(w)->model().gravity()); },
          "Gravity (m/s²), world axes, shape (3,).")
      .def_prop_ro(
          "energy", [](const WorldPtr& w) { return energy(Reading(w)->totals()); },
          "Energies of the world (J): `kinetic`, `potential` and `total`.")
      .def_prop_ro(
          "momentum", [](const WorldPtr& w) { return momentum(Reading(w)->totals()); },
          "Linear (N s) and angular momentum (N m s, about the world's origin), world axes, each of shape (3,).")
      .def_prop_ro(
          "contacts",
          [](const WorldPtr& w) {
            const Reading world(w);
            return contact_records(world->contacts(), world->model());
          },
          "The points at which bodies touch at present, with their forces: a list of `Contact`.")
      .def_prop_ro(
          "mechanisms", [](const WorldPtr& w) { return mechanisms_of(*Reading(w)); },
          "The mechanisms at present: a list of `Mechanism`.")
      .def_prop_ro(
          "bodies", [](const WorldPtr& w) { return python_class("_world", "Bodies")(w); }, "The bodies by name: a mapping.")
      .def_prop_ro(
          "joints", [](const WorldPtr& w) { return python_class("_world", "Joints")(w); }, "The joints by name: a mapping.")
      .def_prop_ro(
          "loops", [](const WorldPtr& w) { return python_class("_world", "Loops")(w); },
          "The joints that close loops, by name: a mapping. `joints` has them, too.")
      .def_prop_ro(
          "loop_status", [](const WorldPtr& w) { return loop_status(Reading(w)->loop_status()); },
          "The equations of the closed loops: `rows`, `rank` and `residual`.")
      .def_prop_ro(
          "couplings",
          [](const WorldPtr& w) {
            const Reading world(w);
            nb::list all;
            for (int c = 0; c < world->couplings(); ++c) {
              const CouplingView view = world->coupling({c});
              const auto [joint, follows] = coupling_names(*world, {c});
              all.append(python_class("_records", "Coupling")(joint,
                                                              follows.empty() ? nb::none() : nb::object(nb::str(follows.c_str())),
                                                              view.ended, view.effort, view.determined));
            }
            return all;
          },
          "The exact couplings of the model, in its order: `joint`, `follows`, `ended`, `effort` and `determined`.")
      .def("_body",
           [](const WorldPtr& w, nb::handle name) {
             const Reading world(w);
             const BodyId body = body_of(*world, *w->simulation, name);
             return BodyObject{w, body, world->model()[body].name};
           })
      .def("_joint",
           [](const WorldPtr& w, nb::handle name) {
             const Reading world(w);
             const JointId joint = joint_of(*world, *w->simulation, name);
             return JointObject{
                 w, joint, is_loop(joint) ? std::string(world->joint_name(joint)) : world->model()[BodyId{joint.index}].name};
           })
      .def("_body_names", [](const WorldPtr& w) { return body_names(*Reading(w)); })
      .def("_joint_names", [](const WorldPtr& w) { return joint_names(*Reading(w)); })
      .def("_loop_names", [](const WorldPtr& w) { return loop_names(*Reading(w)); })
      .def("_has_body",
           [](const WorldPtr& w, const std::string& name) {
             const Reading world(w);
             return world->model().has_body(name) && world->alive(world->model().body(name));
           })
      .def("_has_joint", [](const WorldPtr& w, const std::string& name) { return Reading(w)->find_joint(name) >= 0; });
}

}  // namespace momentree::python
