#pragma once
// Springs of a state document. Internal to its reader.
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// Reads one entry of `springs`, and adds it to the forest if the spring is broken or its law is not the model's. Values that it
/// does not give are the model's.
void read_spring_state(const Value::Entry& entry, const Model& model, Forest& forest, Diagnostics& out);

}  // namespace momentree::io
