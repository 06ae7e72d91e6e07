#include <momentree/scenario/state/joint_json.hpp>

namespace momentree::io {

void write_pose(JsonWriter& json, const char* key, const Pose& pose) {
  json.key(key).begin_object().member("xyz", pose.position).member("quat", pose.rotation).end_object();
}

void write_joint_frame(JsonWriter& json, const JointRecord& joint) {
  const KindInfo& kind = info(joint.kind);
  json.member("kind", kind.name).key("parent");
  if (joint.parent == "ground")
    json.null();
  else
    json.value(joint.parent);
  json.member("child", joint.child);
  write_pose(json, "at", joint.at);
  write_pose(json, "child_at", joint.child_at);
  if (kind.axis) json.member("axis", joint.axis);
  if (kind.axis2) json.member("axis2", joint.axis2);
  if (kind.pitch) json.member("pitch", joint.pitch);
  if (joint.loop) json.member("loop", true);
}

void write_locked(JsonWriter& json, unsigned locked, int nv) {
  json.key("locked");
  if (locked == 0 || locked == (1u << nv) - 1) {
    json.value(locked != 0);
    return;
  }
  json.begin_array();
  for (int i = 0; i < nv; ++i) json.value((locked >> i & 1u) != 0);
  json.end_array();
}

void write_loops(JsonWriter& json, const LoopStatus& loops) {
  json.key("loops").begin_object().member("rows", loops.rows).member("rank", loops.rank).member("residual", loops.residual);
  json.end_object();
}

void write_kinds(JsonWriter& json) {
  const auto write_units = [&](const char* key, const char* letters, const char* angular, const char* linear) {
    json.key(key).begin_array();
    for (; *letters != '\0'; ++letters) json.value(*letters == 'r' ? angular : *letters == 'm' ? linear : "");
    json.end_array();
  };
  json.begin_object();
  for (const KindInfo& kind : all_kinds()) {
    json.key(kind.name).begin_object();
    write_units("q", kind.q_units, "rad", "m");
    write_units("v", kind.v_units, "rad/s", "m/s");
    write_units("p", kind.v_units, "N m s", "N s");
    json.end_object();
  }
  json.end_object();
}

}  // namespace momentree::io
