// The extension module momentree._core.
#include "command.hpp"

NB_MODULE(_core, m) {
  m.attr("__version__") = MOMENTREE_VERSION;
  momentree::python::bind_command(m);
}
