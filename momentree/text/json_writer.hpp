#pragma once
// Writes JSON directly into a string: members in the order given, numbers that read back to the same bits.
#include <span>
#include <string>
#include <string_view>

#include <momentree/math/vec.hpp>

namespace momentree::io {

/// Objects and arrays of objects get their own lines down to `depth` levels; deeper ones are written on one line (0: all on one
/// line).
class JsonWriter {
 public:
  explicit JsonWriter(std::string& text, int depth = 0) : text_(text), depth_(depth) {}

  JsonWriter& begin_object() { return begin('{'); }
  JsonWriter& end_object() { return end('}'); }
  JsonWriter& begin_array() { return begin('['); }
  JsonWriter& end_array() { return end(']'); }
  JsonWriter& key(std::string_view name);

  JsonWriter& value(double number);  ///< null if it is not finite, which JSON cannot represent
  JsonWriter& value(long number);
  JsonWriter& value(int number) { return value(static_cast<long>(number)); }
  JsonWriter& value(bool truth);
  /// Any bytes: invisible characters are escaped, and bytes that are not UTF-8 become U+FFFD.
  JsonWriter& value(std::string_view words);
  JsonWriter& value(const char* words) { return value(std::string_view(words)); }
  JsonWriter& value(const std::string& words) { return value(std::string_view(words)); }
  JsonWriter& value(const Vec3& v);
  JsonWriter& value(const Quat& q);  ///< [w, x, y, z], with the sign that makes w >= 0
  JsonWriter& value(std::span<const double> numbers);
  JsonWriter& null();
  /// A value that is JSON already.
  JsonWriter& raw(std::string_view json);

  template <class Value>
  JsonWriter& member(std::string_view name, const Value& v) {
    key(name);
    return value(v);
  }

 private:
  JsonWriter& begin(char bracket);
  JsonWriter& end(char bracket);
  void before_item();
  void line();

  std::string& text_;
  int depth_, level_ = 0;
  bool first_ = true, after_key_ = false;
};

/// The same rotation with w >= 0.
constexpr Quat with_positive_w(const Quat& q) { return q.w < 0 ? Quat{-q.w, -q.x, -q.y, -q.z} : q; }

}  // namespace momentree::io
