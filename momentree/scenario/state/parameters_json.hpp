#pragma once
// A joint's parameters in a state document, with the keys of joint_keys.hpp; the numbers read back to the same bits.
#include <momentree/joint/joint.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

/// Writes an object with the same keys as in a scenario; parameters that the joint does not have are omitted. JSON numbers are
/// finite: null represents infinity.
void write_parameters(JsonWriter& json, const JointParameters& parameters);
/// Reports everything that is wrong.
JointParameters parameters_of(const Value& value, Diagnostics& out);

}  // namespace momentree::io
