// The extension module momentree._core.
#include <nanobind/nanobind.h>

NB_MODULE(_core, m) { m.attr("__version__") = MOMENTREE_VERSION; }
