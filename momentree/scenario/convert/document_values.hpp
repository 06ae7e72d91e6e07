#pragma once
// Builds parts of a document that will be written. Internal to the writers.
#include <initializer_list>
#include <string>
#include <utility>

#include <momentree/base/value.hpp>
#include <momentree/math/values.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io::document_values {

template <class T>
Value value(T data) {
  return Value(std::move(data), Place{});
}
inline Value number(double x) { return value(x == 0 ? 0.0 : x); }  // never minus zero
inline Value text(std::string s) { return value(std::move(s)); }
inline Value list(const Vec3& a) { return value(Value::Array{number(a.x), number(a.y), number(a.z)}); }

inline void add(Value::Table& table, const char* key, Value v) { table.push_back({key, {}, std::move(v)}); }

/// Fixed-axes angles of a rotation (rad), accurate to the last bits everywhere, with as few digits as reproduce the same
/// quaternion; `exact`: whether such angles exist.
struct Rpy {
  Vec3 angles;
  bool exact = false;
};
Rpy rpy_of(const Quat& rotation);

/// A name without its mechanism.
inline std::string bare(const std::string& name) { return name.substr(name.find('/') + 1); }

/// { xyz, rpy or quat } without zero entries; an empty table for the identity.
Value::Table placement(const Pose& pose);

}  // namespace momentree::io::document_values
