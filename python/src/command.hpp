#pragma once
#include <nanobind/nanobind.h>

namespace momentree::python {

/// main(argv): the command, for `python -m momentree` and the script `momentree`.
void bind_command(nanobind::module_& m);

}  // namespace momentree::python
