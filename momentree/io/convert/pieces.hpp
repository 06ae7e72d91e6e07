#pragma once
// Parts of a document that is to be written. Internal to the writers.
#include <initializer_list>
#include <string>
#include <utility>

#include <momentree/base/value.hpp>
#include <momentree/math/values.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io::pieces {

template <class T>
Value value(T data) {
  return Value(std::move(data), Place{});
}
inline Value number(double x) { return value(x == 0 ? 0.0 : x); }  // no minus zero
inline Value text(std::string s) { return value(std::move(s)); }
inline Value list(const Vec3& a) { return value(Value::Array{number(a.x), number(a.y), number(a.z)}); }

inline void add(Value::Table& table, const char* key, Value v) { table.push_back({key, {}, std::move(v)}); }

/// Fixed-axes angles of a rotation, to its last bits wherever it is, and in as few digits as turn to the very same quaternion;
/// `exact`: whether there are such.
struct Rpy {
  Vec3 angles;
  bool exact = false;
};
Rpy rpy_of(const Quat& rotation);

/// { xyz, rpy or quat } without what is zero; an empty table for no displacement.
Value::Table placement(const Pose& pose);

}  // namespace momentree::io::pieces
