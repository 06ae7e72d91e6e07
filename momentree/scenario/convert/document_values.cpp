#include <momentree/scenario/convert/document_values.hpp>

#include <charconv>
#include <cmath>

namespace momentree::io::document_values {

namespace {

bool same(const Quat& a, const Quat& b) { return a.w == b.w && a.x == b.x && a.y == b.y && a.z == b.z; }
bool gives(const Vec3& angles, const Quat& rotation) { return same(from_rpy(angles.x, angles.y, angles.z), rotation); }

double rounded(double x, int decimals) {
  char text[64];
  const std::to_chars_result end = std::to_chars(text, text + sizeof text, x, std::chars_format::fixed, decimals);
  double value = 0;
  std::from_chars(text, end.ptr, value);
  return value;
}

}  // namespace

Rpy rpy_of(const Quat& rotation) {
  const Mat3 R = rotation_matrix(rotation);
  // The yaw first, then the remaining roll: if both rotate about one axis, only their sum matters.
  const double pitch = std::atan2(-R.zx, std::hypot(R.xx, R.yx)), yaw = std::atan2(R.yx, R.xx);
  const double s = std::sin(yaw), c = std::cos(yaw);
  const Vec3 full{std::atan2(s * R.xz - c * R.yz, c * R.yy - s * R.xy), pitch, yaw};
  for (int decimals = 0; decimals <= 16; ++decimals) {
    const Vec3 few{rounded(full.x, decimals), rounded(full.y, decimals), rounded(full.z, decimals)};
    if (gives(few, rotation)) return {few, true};
  }
  return {full, gives(full, rotation)};
}

Value::Table placement(const Pose& pose) {
  Value::Table table;
  const Vec3& p = pose.position;
  const Quat& r = pose.rotation;
  if (p.x != 0 || p.y != 0 || p.z != 0) add(table, "xyz", list(p));
  if (std::fabs(r.w) == 1 && r.x == 0 && r.y == 0 && r.z == 0) return table;
  const Rpy rpy = rpy_of(r);
  if (rpy.exact)
    add(table, "rpy", list(rpy.angles));
  else
    add(table, "quat", value(Value::Array{number(r.w), number(r.x), number(r.y), number(r.z)}));
  return table;
}

}  // namespace momentree::io::document_values
