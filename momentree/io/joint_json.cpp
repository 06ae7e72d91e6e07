#include <momentree/io/joint_json.hpp>

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

}  // namespace momentree::io
