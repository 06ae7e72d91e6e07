// The extension module momentree._core: bindings without physics of their own.
#include "binding.hpp"
#include "command.hpp"

NB_MODULE(_core, m) {
  namespace py = momentree::python;
  m.attr("__version__") = MOMENTREE_VERSION;
  py::bind_command(m);
  py::register_errors(m);
  py::register_model(m);
  py::register_world(m);
  py::register_simulation(m);
  py::register_vocabulary(m);
  py::register_batch(m);
}
