#pragma once
// C++ records as Python objects.
#include <momentree/simulate/event.hpp>

#include "binding.hpp"

namespace momentree::python {

/// momentree.Event.
nb::object event_record(const Event& event);

}  // namespace momentree::python
