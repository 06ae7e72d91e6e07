#pragma once
// Contacts of a state document. Internal to its writer and its reader.
#include <momentree/scenario/state/state_joint.hpp>
#include <momentree/simulate/stepping/stepping_state.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

/// The list of closed contacts, those that are pending, and the points of the last step of time stepping.
void write_contacts(JsonWriter& json, const World& world, const SteppingState& stepping);
/// What a run with contacts remembers between steps besides these points.
void write_stepping(JsonWriter& json, const World& world, const SteppingState& stepping);

/// Reads `contacts`: closed ones into the forest, points of time stepping into `stepping`. Pending ones are left out.
void read_contacts(const Value& list, const Model& model, JointReader& joints, Forest& forest, SteppingState& stepping,
                   Diagnostics& out);
/// Reads what write_stepping() wrote.
void read_stepping(const Value& value, const Model& model, JointReader& joints, SteppingState& stepping, Diagnostics& out);

}  // namespace momentree::io
