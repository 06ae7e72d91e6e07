// The extension module momentree._core: bindings without physics of their own.
#include <cstdlib>

#include <cli/commit.hpp>

#include "binding.hpp"
#include "command.hpp"

const char* momentree::python::commit() { return cli::commit; }

NB_MODULE(_core, m) {
  namespace py = momentree::python;
  // A program that ends while a module-level variable is in a traceback would print a page of warnings. The tests turn them on.
  nanobind::set_leak_warnings(std::getenv("MOMENTREE_LEAK_WARNINGS") != nullptr);
  m.attr("__version__") = MOMENTREE_VERSION;
  py::bind_command(m);
  m.def("_seconds", &py::seconds_of);
  py::register_errors(m);
  py::register_model(m);
  py::register_world(m);
  py::register_simulation(m);
  py::register_vocabulary(m);
  py::register_batch(m);
  py::register_sweep(m);
  py::register_live(m);
}
