#pragma once
// C++ records as Python objects.
#include <momentree/simulate/event.hpp>

#include "binding.hpp"

namespace momentree::python {

/// momentree.LoopStatus.
nb::object loop_status(const LoopStatus& status);
/// momentree.Event.
nb::object event_record(const Event& event);

}  // namespace momentree::python
