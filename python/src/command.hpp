#pragma once
#include <nanobind/nanobind.h>

namespace momentree::python {

/// main(argv): the command, for `python -m momentree` and the script `momentree`.
void bind_command(nanobind::module_& m);

/// What the extension is made from; empty if that is not known. In a file of its own, because it changes often.
const char* commit();

}  // namespace momentree::python
