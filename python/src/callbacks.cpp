// Python functions as conditions, drives and forces.
#include <limits>
#include <memory>

#include "world_object.hpp"

namespace momentree::python {

namespace {

// Invalidates what was passed to a function when the call ends.
struct PassedWorld {
  PassedWorld(SimulationObject& object, const World& world)
      : view(std::make_shared<WorldObject>(WorldObject{object.shared_from_this(), &world, true})) {}
  ~PassedWorld() { view->passed = nullptr; }
  PassedWorld(const PassedWorld&) = delete;
  PassedWorld& operator=(const PassedWorld&) = delete;
  WorldPtr view;
};
struct PassedContext {
  PassedContext(SimulationObject& object, const EvaluationContext& context)
      : view(std::make_shared<ContextObject>(ContextObject{&object, &context})) {}
  ~PassedContext() { view->context = nullptr; }
  PassedContext(const PassedContext&) = delete;
  PassedContext& operator=(const PassedContext&) = delete;
  std::shared_ptr<ContextObject> view;
};

double number_of(const nb::object& result, const char* what) {
  double x = 0;
  if (!nb::try_cast(result, x)) refuse(std::string(what) + " returned something that is not a number");
  return x;
}

}  // namespace

Measure measure_of(nb::handle function) {
  return measured([f = function](const World& world) {
    SimulationObject* const simulation = SimulationObject::current();
    if (simulation == nullptr) return std::numeric_limits<double>::quiet_NaN();
    const nb::gil_scoped_acquire gil;
    const Within measuring(*simulation, Inside::measure);
    const PassedWorld passed(*simulation, world);
    return number_of(f(passed.view), "a condition's function");
  });
}

JointFunction drive_of(std::shared_ptr<SimulationObject::JointInput> input) {
  return [input = std::move(input)](const EvaluationContext& context, std::span<double> efforts) {
    for (std::size_t i = 0; i < std::min(efforts.size(), input->extra.size()); ++i) efforts[i] += input->extra[i];
    SimulationObject* const self = SimulationObject::current();
    if (!input->function.is_valid() || self == nullptr) return;  // null: of a record, where efforts do not matter
    const nb::gil_scoped_acquire gil;
    const Within driving(*self, Inside::drive);
    const bool good = self->guarded([&] {
      const PassedContext passed(*self, context);
      const nb::object result = input->function(passed.view);
      double x = 0;
      if (efforts.size() == 1 && nb::try_cast(result, x)) {
        efforts[0] += x;
        return;
      }
      const std::vector<double> all = numbers_of(result, efforts.size(), 0, "a drive's function", false);
      for (std::size_t i = 0; i < all.size(); ++i) efforts[i] += all[i];
    });
    if (!good)
      for (double& effort : efforts) effort = std::numeric_limits<double>::quiet_NaN();  // ends the run
  };
}

BodyFunction force_of(nb::handle function) {
  return [f = function](const EvaluationContext& context) {
    SimulationObject* const self = SimulationObject::current();
    if (self == nullptr) return Wrench{};
    const nb::gil_scoped_acquire gil;
    const Within driving(*self, Inside::drive);
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    Wrench wrench{{none, none, none}, {none, none, none}};
    self->guarded([&] {
      const PassedContext passed(*self, context);
      const nb::object result = f(passed.view);
      const char* const what = "a force's function";
      if (!PySequence_Check(result.ptr()) || nb::len(result) != 2)
        refuse(std::string(what) + " did not return a force and a torque", "return (fx, fy, fz), (tx, ty, tz)");
      wrench = {to_vec3(result[0], what), to_vec3(result[1], what)};
    });
    return wrench;
  };
}

}  // namespace momentree::python
