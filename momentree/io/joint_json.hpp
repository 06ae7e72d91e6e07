#pragma once
// How a joint is described in model.json, in state documents and in events.jsonl.
#include <momentree/io/json_writer.hpp>
#include <momentree/simulate/event.hpp>

namespace momentree::io {

/// {"xyz": [x, y, z], "quat": [w, x, y, z]}
void write_pose(JsonWriter& json, const char* key, const Pose& pose);

/// Members of an object that is open: kind, parent (null: the ground), child, at, child_at, and the axes and pitch that its kind
/// has.
void write_joint_frame(JsonWriter& json, const JointRecord& joint);

/// Member `locked`: true or false, or a list with one of them per freedom where only some of the `nv` freedoms are locked.
void write_locked(JsonWriter& json, unsigned locked, int nv);

}  // namespace momentree::io
