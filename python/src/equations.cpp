// Evaluation: rates, accelerations, the equations of motion as matrices, and what follows from these.
#include <algorithm>
#include <cstring>

#include <momentree/simulate/analysis/equilibrium.hpp>
#include <momentree/simulate/analysis/inverse_kinematics.hpp>
#include <momentree/simulate/analysis/linearization.hpp>

#include "world_object.hpp"

namespace momentree::python {

namespace {

std::size_t nv_of(const World& world) { return static_cast<std::size_t>(world.tree().nv()); }

nb::object evaluate(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const std::shared_ptr<StateArrays>& arrays = self->arrays();
  const World& world = self->simulation().world();
  const Numbers qdot = world.qdot(), pdot = world.pdot();
  if (!qdot.empty()) std::memcpy(arrays->qdot.data(), qdot.data(), qdot.size_bytes());
  if (!pdot.empty()) std::memcpy(arrays->pdot.data(), pdot.data(), pdot.size_bytes());
  if (!self->views.rates.is_valid())
    self->views.rates =
        python_class("_records", "Rates")(state_view(arrays, arrays->qdot, "qdot"), state_view(arrays, arrays->pdot, "pdot"));
  return self->views.rates;
}

nb::object accelerations(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  return copy_of(self->simulation().world().a());
}

template <class Compute>
auto matrix_of(Compute compute) {
  return [compute](const SimulationPtr& self) {
    const Use use(*self, Access::read);
    const World& world = self->simulation().world();
    NewArray matrix = new_array(nv_of(world), nv_of(world));
    compute(world, matrix.data);
    return std::move(matrix.object);
  };
}

nb::object solve_mass(const SimulationPtr& self, nb::handle r) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  const std::vector<double> given = numbers_of(r, nv_of(world), 0, "r");
  NewArray array = new_array(nv_of(world));
  world.equations().solve_mass(given.data(), array.data);
  return std::move(array.object);
}

template <class Compute>
auto vector_of(Compute compute) {
  return [compute](const SimulationPtr& self) {
    const Use use(*self, Access::read);
    const World& world = self->simulation().world();
    NewArray array = new_array(nv_of(world));
    compute(world, array.data);
    return std::move(array.object);
  };
}

nb::object inverse_dynamics(const SimulationPtr& self, nb::handle a) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  const std::vector<double> given = numbers_of(a, nv_of(world), 0, "a");
  NewArray array = new_array(nv_of(world));
  world.equations().inverse_dynamics(given.data(), array.data);
  return std::move(array.object);
}

nb::object jacobian(const SimulationPtr& self, nb::handle body, nb::handle point) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  const BodyId id = body_of(world, *self, body);
  const Vec3 where = point.is_none() ? Vec3{} : to_vec3(point, "point");
  NewArray matrix = new_array(6, nv_of(world));
  world.equations().point_jacobian(id, where, matrix.data);
  return std::move(matrix.object);
}

nb::object totals_as(const SimulationPtr& self, bool energy) {
  const Use use(*self, Access::read);
  const Totals t = self->simulation().world().totals();
  if (energy) return python_class("_records", "Energy")(t.kinetic, t.potential);
  return python_class("_records", "Momentum")(from_vec3(t.linear), from_vec3(t.angular));
}

nb::object array_of(const DenseMatrix& matrix) {
  NewArray array = new_array(static_cast<std::size_t>(matrix.rows), static_cast<std::size_t>(matrix.columns));
  std::copy(matrix.numbers.begin(), matrix.numbers.end(), array.data);
  return std::move(array.object);
}

/// As columns of results: "arm/elbow.v0".
nb::list dof_names(const World& world) {
  const Tree& tree = world.tree();
  std::vector<std::string> names(static_cast<std::size_t>(tree.nv()));
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      names[static_cast<std::size_t>(tree.first_p(b) + i)] =
          std::string(world.joint_name(tree.inboard_joint({b}))) + ".v" + std::to_string(i);
  nb::list all;
  for (const std::string& name : names) all.append(nb::str(name.c_str()));
  return all;
}

nb::tuple linearized(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  const Linearization all = linearize(world);
  return nb::make_tuple(array_of(all.A), array_of(all.B), array_of(all.projection), dof_names(world));
}

nb::tuple balanced(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  const Equilibrium found = equilibrium(world);
  const std::size_t nv = static_cast<std::size_t>(world.tree().nv());
  NewArray squares = new_array(found.modes.size()), shapes = new_array(found.modes.size(), nv);
  for (std::size_t k = 0; k < found.modes.size(); ++k) {
    squares.data[k] = found.modes[k].square;
    std::copy(found.modes[k].shape.begin(), found.modes[k].shape.end(), shapes.data + k * nv);
  }
  const nb::list names = dof_names(world);
  nb::list resting;
  for (const int i : found.resting) resting.append(names[static_cast<std::size_t>(i)]);
  nb::list taut;
  for (const int i : found.taut) taut.append(nb::str(world.model().springs()[static_cast<std::size_t>(i)].name.c_str()));
  return nb::make_tuple(copy_of(found.q), found.residual, found.iterations, squares.object, shapes.object, resting, taut, names);
}

nb::tuple posed(const SimulationPtr& self, nb::list targets, double tolerance, int iterations, int attempts, std::uint64_t seed) {
  const Use use(*self, Access::read);
  const World& world = self->simulation().world();
  std::vector<KinematicTarget> all;
  for (const nb::handle each : targets) {
    const auto fields = nb::cast<nb::tuple>(each);  // body, position, orientation, point, weight
    KinematicTarget target{.body = body_of(world, *self, fields[0])};
    if (!fields[1].is_none()) target.position = to_vec3(fields[1], "position");
    if (!fields[2].is_none()) {
      const std::vector<double> q = numbers_of(fields[2], 4, 0, "orientation");
      target.orientation = Quat{q[0], q[1], q[2], q[3]};
    }
    if (!fields[3].is_none()) target.point = to_vec3(fields[3], "point");
    target.weight = nb::cast<double>(fields[4]);
    all.push_back(target);
  }
  const KinematicSolution found =
      inverse_kinematics(world, all, {.tolerance = tolerance, .iterations = iterations, .attempts = attempts, .seed = seed});
  return nb::make_tuple(found.reached, copy_of(found.q), found.position_error, found.angle_error, found.iterations,
                        found.attempts);
}

}  // namespace

void register_equations(SimulationClass& simulation) {
  simulation
      .def("evaluate", &evaluate,
           "Time derivatives of the state at this instant, by the O(n) recursions (20) to (27) of the paper.\n\n"
           "Returns:\n    `Rates(qdot, pdot)`: qdot (rad/s, m/s; of quaternions 1/s), shape (nq,), and pdot (N m, N), shape "
           "(nv,). "
           "The same two arrays are\n    filled by each evaluation, and are stale after a change of topology, like `q`.")
      .def("accelerations", &accelerations,
           "Time derivatives of v (rad/s², m/s²), shape (nv,), packed by joint number, a copy. Equations (30) to (51) of the "
           "paper.")
      .def("mass_matrix", matrix_of([](const World& world, double* out) { world.equations().mass_matrix(out); }),
           "Joint-space mass matrix M(q), symmetric, armatures included, shape (nv, nv), a copy. The canonical momenta (19) are "
           "p = M v.\n\nIn kg m² for angles, kg for displacements and kg m between them. It costs O(n²); `evaluate` and "
           "`accelerations` do\nwithout it.")
      .def(
          "solve_mass", &solve_mass, "r"_a,
          "M⁻¹ r, shape (nv,), a copy: the velocities that momenta r have, or the accelerations that further efforts r cause.\n\n"
          "Degrees of freedom that are locked or have a prescribed motion get zero. O(n), without M.\n\n"
          "Args:\n    r: Momenta, or efforts (N m, N), shape (nv,).\n\n"
          "Raises:\n    Error: The shape is wrong, or a number is not finite.")
      .def("inverse_mass_matrix", matrix_of([](const World& world, double* out) { world.equations().inverse_mass_matrix(out); }),
           "Inverse of the joint-space mass matrix, symmetric, shape (nv, nv), a copy, in the inverse units of `mass_matrix`: "
           "1/(kg m²), 1/kg.\n\nRows and columns of degrees of freedom that are locked or have a prescribed motion are zero. "
           "O(n²).")
      .def("bias", vector_of([](const World& world, double* out) { world.equations().bias(out); }),
           "Bias c(q, v) of the equations of motion M dv/dt + c = efforts (N m, N), shape (nv,), a copy.\n\n"
           "It contains gravity, Coriolis and centrifugal terms and forces on bodies, but no efforts of joints.")
      .def("efforts", vector_of([](const World& world, double* out) { world.equations().efforts(out); }),
           "All efforts along the degrees of freedom (N m, N), shape (nv,), a copy: drives, springs, dampers, friction, Python "
           "functions, `effort`.")
      .def("inverse_dynamics", &inverse_dynamics, "a"_a,
           "Efforts that give the joints these accelerations: M a + c (N m, N), shape (nv,), a copy.\n\n"
           "Args:\n    a: Time derivatives of v (rad/s², m/s²), shape (nv,).\n\n"
           "Raises:\n    Error: The shape is wrong, or a number is not finite.")
      .def("jacobian", &jacobian, "body"_a, "point"_a = nb::none(),
           "Jacobian J of a point of a body, world axes, shape (6, nv), a copy: J v is the point's velocity (m/s), then the "
           "body's "
           "angular\nvelocity (rad/s).\n\n"
           "Args:\n    body: Name or handle.\n    point: In the body's frame (m), shape (3,); default: its origin.\n\n"
           "Raises:\n    Error: The name is unknown, or the handle is of another simulation.")
      .def("_linearize", &linearized)
      .def("_equilibrium", &balanced)
      .def("_inverse_kinematics", &posed, "targets"_a, "tolerance"_a, "iterations"_a, "attempts"_a, "seed"_a)
      .def_prop_ro(
          "energy", [](const SimulationPtr& self) { return totals_as(self, true); },
          "Energies of the world (J): `kinetic`, `potential` and `total`.")
      .def_prop_ro(
          "momentum", [](const SimulationPtr& self) { return totals_as(self, false); },
          "Linear (N s) and angular momentum (N m s, about the world's origin), world axes, each of shape (3,), copies.");
}

}  // namespace momentree::python
