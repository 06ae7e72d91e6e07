#pragma once
// The description of a joint in model.json, in state documents and in events.jsonl, and of the kinds of joint for pages.
#include <momentree/simulate/events/event.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

/// {"xyz": [x, y, z], "quat": [w, x, y, z]}; xyz in m
void write_pose(JsonWriter& json, const char* key, const Pose& pose);

/// Writes members into an open object: kind, parent (null: the ground), child, at, child_at, and the axes and pitch that its
/// kind has.
void write_joint_frame(JsonWriter& json, const JointRecord& joint);

/// Member `locked`: true or false, or a list of one boolean per DoF if only some of the `nv` DoFs are locked.
void write_locked(JsonWriter& json, unsigned locked, int nv);

/// Member `loops`: {"rows": 5, "rank": 2, "residual": 1e-17}.
void write_loops(JsonWriter& json, const LoopStatus& loops);

/// {"revolute": {"q": ["rad"], "v": ["rad/s"], "p": ["N m s"]}, …}: the units of the coordinates, velocities and momenta of each
/// kind; "" for the components of a quaternion.
void write_kinds(JsonWriter& json);

}  // namespace momentree::io
