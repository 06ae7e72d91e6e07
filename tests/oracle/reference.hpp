#pragma once
// Models and functions shared by the tests against reference data.
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/simulate/simulation.hpp>

namespace momentree::oracle {

inline nlohmann::json reference(const std::string& file) {
  std::ifstream in(std::string(MOMENTREE_SOURCE_DIR) + "/tests/data/" + file);
  REQUIRE_MESSAGE(in, "tests/data/" << file);
  return nlohmann::json::parse(in);
}

inline JointSpec joint_of(Kind kind, Vec3 axis = {0, 0, 1}, Vec3 axis2 = {}) {
  JointSpec spec;
  spec.kind = kind;
  spec.axis = axis;
  spec.axis2 = axis2;
  return spec;
}
inline Vec3 vec3_of(const nlohmann::json& a) { return {a[0], a[1], a[2]}; }
inline Quat quat_of(const nlohmann::json& a) { return {a[0], a[1], a[2], a[3]}; }
inline Values values_of(const nlohmann::json& a) {
  Values values;
  for (const double x : a) values.push_back(x);
  return values;
}

/// Largest difference of components.
inline double apart(const Vec3& a, const Vec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}
/// The same for attitudes: a quaternion and its negative are equivalent.
inline double apart(const Quat& a, const Quat& b) {
  const double s = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -1 : 1;
  return std::max({std::abs(a.w - s * b.w), std::abs(a.x - s * b.x), std::abs(a.y - s * b.y), std::abs(a.z - s * b.z)});
}

/// |measured − expected| ≤ bound, with both numbers in the message.
inline void check_near(double measured, double expected, double bound, const std::string& what) {
  INFO(what << ": " << measured << " for " << expected << ", off by " << measured - expected);
  CHECK(std::abs(measured - expected) <= bound);
}
inline void check_near(const Vec3& measured, const Vec3& expected, double bound, const std::string& what) {
  INFO(what << " off by " << apart(measured, expected));
  CHECK(apart(measured, expected) <= bound);
}

}  // namespace momentree::oracle
