#pragma once
// C++ records as Python objects.
#include <span>

#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/world/world.hpp>

#include "binding.hpp"

namespace momentree::python {

/// momentree.LoopStatus.
nb::object loop_status(const LoopStatus& status);
/// momentree.Event.
nb::object event_record(const Event& event);
/// momentree.Contact, of points at which bodies of this model touch.
nb::list contact_records(std::span<const ContactPoint> points, const Model& model);

}  // namespace momentree::python
