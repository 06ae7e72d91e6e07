#pragma once
// A joint's parameters in a state document; the numbers read back to the same bits.
#include <momentree/io/json_document.hpp>
#include <momentree/io/json_writer.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::io {

/// Writes an object with the same keys as in a scenario; parameters that the joint does not have are omitted.
void write_parameters(JsonWriter& json, const JointParameters& parameters);
/// Throws Error at the first mistake.
JointParameters parameters_of(const JsonDocument& document, const JsonNode& node);

}  // namespace momentree::io
