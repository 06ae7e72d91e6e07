#pragma once
// A table of a result file that is read back: every key that is read must exist, except for find().
#include <string>

#include <momentree/base/describe.hpp>
#include <momentree/scenario/keys/fields.hpp>

namespace momentree::io {

/// The hint for a result file that lacks something.
inline constexpr const char* damaged = "the file was truncated or modified: run again, or remove it";

/// Reports keys that are missing or have another type, and then returns an empty value. Other keys are ignored.
class Record {
 public:
  Record(const Value& value, const char* where, Diagnostics& out)
      : fields_(value, where, out, ""), out_(out), none_(Value::Null{}, value.place) {}

  const Value* find(const char* key) { return fields_.find(key); }
  const Value& operator[](const char* key) {
    const Value* value = fields_.require(key, damaged);
    return value ? *value : none_;
  }
  double number(const char* key) { return read_real((*this)[key], key, out_).value_or(0); }
  std::string text(const char* key) { return read_string((*this)[key], key, out_).value_or(""); }
  Vec3 vec(const char* key) { return vec((*this)[key], key); }
  Vec3 vec(const Value& value, const char* what) {
    const std::vector<double> x = read_reals(value, 3, what, out_);
    return x.empty() ? Vec3{} : Vec3{x[0], x[1], x[2]};
  }
  /// Visits the members of a described type.
  void operator()(const char* key, double& x, const Field&) { x = number(key); }
  void operator()(const char* key, Vec3& x, const Field&) { x = vec(key); }
  const Value::Array& list(const char* key) { return read_list((*this)[key], key, out_); }
  const Value::Table& table(const char* key) { return read_table((*this)[key], key, out_); }

 private:
  Fields fields_;
  Diagnostics& out_;
  const Value none_;
};

}  // namespace momentree::io
