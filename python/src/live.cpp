// The live view: a page in the browser that shows a simulation while Python runs it.
#include <chrono>
#include <cmath>
#include <utility>

#include <nanobind/stl/tuple.h>

#include <momentree/live/view.hpp>

#include "simulation_object.hpp"

namespace momentree::python {

namespace {

struct ViewObject {
  SimulationPtr simulation;                           // outlives the view
  std::vector<std::pair<std::string, double>> moved;  ///< sliders, since the last exchange
  std::unique_ptr<live::View> view;
};

void make(ViewObject* self, const SimulationPtr& simulation, const std::string& title, int port, bool browser, bool paused,
          double speed) {
  const Use use(*simulation, Access::change);
  live::ViewOptions options{.title = title, .port = port, .open_browser = browser, .paused = paused, .speed = speed};
  auto view = std::make_unique<live::View>(simulation->simulation(), simulation->scenario(), std::move(options));
  new (self) ViewObject{simulation, {}, std::move(view)};
}

void add_slider(ViewObject& self, const std::string& name, double least, double most, double value, const std::string& unit) {
  const Use use(*self.simulation, Access::change);
  const auto changed = [&self, name](double to) { self.moved.emplace_back(name, to); };
  self.view->slider({.name = name, .least = least, .most = most, .value = value, .unit = unit, .changed = changed});
}

// Sliders that were moved, with their values in order.
std::vector<std::pair<std::string, double>> exchange(ViewObject& self) {
  const Use use(*self.simulation, Access::change);
  self.view->exchange();
  return std::exchange(self.moved, {});
}

void wait(ViewObject& self, double seconds) {
  const nb::gil_scoped_release free;
  self.view->wait(std::chrono::nanoseconds(static_cast<long long>(1e9 * seconds)));
}

// One frame of a run at the page's speed, if it is due; false: it is not due.
bool advance(ViewObject& self, double until) {
  SimulationObject& simulation = *self.simulation;
  const Use use(simulation, Access::change);
  const double target = self.view->next(until);
  if (!(target > simulation.simulation().time())) return false;
  const RunResult result = simulation.run_until(target);
  self.view->report(result);
  if (!result && result != Status::interrupted) SimulationObject::throw_run_error(result);
  return true;
}

}  // namespace

void register_live(nb::module_& m) {
  nb::class_<ViewObject>(m, "_LiveView")
      .def("__init__", &make, "simulation"_a, "title"_a, "port"_a, "browser"_a, "paused"_a, "speed"_a)
      .def_prop_ro("address", [](const ViewObject& self) { return self.view->address(); })
      .def_prop_ro("warnings", [](const ViewObject& self) { return self.view->warnings(); })
      .def_prop_ro("playing", [](const ViewObject& self) { return self.view->playing(); })
      .def_prop_ro("stopped", [](const ViewObject& self) { return self.view->stopped(); })
      .def_prop_ro("pages", [](const ViewObject& self) { return self.view->pages(); })
      .def("slider", &add_slider, "name"_a, "least"_a, "most"_a, "value"_a, "unit"_a)
      .def(
          "value", [](const ViewObject& self, const std::string& name) { return self.view->value(name); }, "name"_a)
      .def("exchange", &exchange)
      .def("advance", &advance, "until"_a)
      .def("wait", &wait, "seconds"_a)
      .def("close", [](ViewObject& self) {
        const Use use(*self.simulation, Access::change);
        self.view->close();
      });
}

}  // namespace momentree::python
