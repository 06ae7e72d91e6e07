#pragma once
// A joint's parameters in a state document: written so that they read back to the same bits.
#include <momentree/io/json_document.hpp>
#include <momentree/io/json_writer.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::io {

/// As an object with the keys that a scenario has for them; what a joint does not have is left out.
void write_parameters(JsonWriter& json, const JointParameters& parameters);
/// Throws Error at the first thing that is wrong.
JointParameters parameters_of(const JsonDocument& document, const JsonNode& node);

}  // namespace momentree::io
