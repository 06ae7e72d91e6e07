#pragma once
// Visitors of described types (base/describe.hpp): the keys of their tables, readers and writers of scenarios and of documents in
// JSON. Internal to readers and writers.
#include <cmath>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/model/model.hpp>
#include <momentree/scenario/convert/document_values.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/scenario/keys/keys.hpp>
#include <momentree/text/json_writer.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

/// A point of a body in a document.
inline constexpr Type body_point = type::other(R"({"anyOf": [{"type": "string"}, @]})", point_table);

/// Collects the keys of a table.
class KeyCollector {
 public:
  template <class T>
  explicit KeyCollector(const T& standard) {
    describe(*this, standard);
  }
  KeyCollector(const KeyCollector&) = delete;  // keys point to texts
  KeyCollector& operator=(const KeyCollector&) = delete;
  ~KeyCollector() = default;
  void operator()(const char* key, const std::string&, const Field& field) { add(key, type::string, field); }
  void operator()(const char* key, bool standard, const Field& field) {
    add(key, type::boolean, field, standard ? "true" : "false");
  }
  void operator()(const char* key, double standard, const Field& field) {
    const char* const text = std::isfinite(standard) && field.required == nullptr ? kept(number_text(standard)) : nullptr;
    if (field.of_joint)
      return add(key, type::number(kept(unit_of(field.dimension) + " or " + unit_of(field.along)), field.range), field, text);
    add(key, type::number(field.dimension, field.range), field, text);
  }
  void operator()(const char* key, JointId, const Field& field) { add(key, type::string, field); }
  void operator()(const char* key, const std::optional<double>&, const Field& field) {
    add(key, type::number(field.dimension, field.range), field);
  }
  void operator()(const char* key, const Vec3&, const Field& field) {
    add(key, type::vector(field.dimension, field.range), field);
  }
  void operator()(const char* key, const SpringEnd&, const Field& field) { add(key, body_point, field); }

  KeyList keys() const { return keys_; }

 private:
  void add(const char* key, const Type& type, const Field& field, const char* standard = nullptr) {
    keys_.push_back({key, type, field.about, standard, field.required, nullptr, field.absent});
  }
  const char* kept(std::string text) { return texts_.emplace_back(std::move(text)).c_str(); }
  std::vector<Key> keys_;
  std::list<std::string> texts_;
};

/// The keys of the table of a described type, for KeyTable::described.
template <class T>
KeyList keys_of() {
  static const KeyCollector collector{T{}};
  return collector.keys();
}

/// Reads the members of a scenario's table. Absent ones keep their values. Derive a reader for members that refer to others.
class FieldReader {
 public:
  explicit FieldReader(Fields& fields) : fields_(fields) {}
  void operator()(const char* key, double& x, const Field& field) {
    if (field.required != nullptr) fields_.require(key);
    x = fields_.number(key).value_or(x);
  }
  void operator()(const char* key, std::optional<double>& x, const Field&) {
    if (const auto given = fields_.number(key)) x = given;
  }
  void operator()(const char* key, Vec3& x, const Field& field) {
    if (field.required != nullptr) fields_.require(key);
    x = fields_.vec3(key).value_or(x);
  }
  void operator()(const char* key, bool& x, const Field&) { x = fields_.boolean(key).value_or(x); }

 protected:
  Fields& fields_;
};

/// Writes a scenario's table. Members with their default values are left out.
class TableWriter {
 public:
  explicit TableWriter(const Model& model) : model_(model) {}

  template <class T>
  [[nodiscard]] Value::Table of(const T& value) {
    const T standard;
    comparing_ = true;
    describe(*this, standard);
    comparing_ = false;
    describe(*this, value);
    return std::move(table_);
  }

  void operator()(const char* key, const std::string& name, const Field&) {
    if (!comparing_) document_values::add(table_, key, document_values::text(name));
  }
  void operator()(const char* key, double x, const Field&) {
    if (comparing_) return standard_.push_back(x);
    if (x != standard_[next_++]) document_values::add(table_, key, document_values::number(x));
  }
  void operator()(const char* key, const std::optional<double>& x, const Field&) {
    if (!comparing_ && x) document_values::add(table_, key, document_values::number(*x));
  }
  void operator()(const char* key, bool x, const Field&) {
    if (comparing_) return standard_.push_back(x);
    if (x != (standard_[next_++] != 0)) document_values::add(table_, key, document_values::value(x));
  }
  void operator()(const char* key, JointId joint, const Field&) {
    if (!comparing_) document_values::add(table_, key, document_values::text(model_[joint].joint_name));
  }
  void operator()(const char* key, const SpringEnd& end, const Field&) {
    if (comparing_) return;
    Value::Table table;
    document_values::add(table, "body", document_values::text(std::string(model_.body_name(end.body))));
    if (!(end.point == Vec3{})) document_values::add(table, "point", document_values::list(end.point));
    document_values::add(table_, key, document_values::value(std::move(table)));
  }

 private:
  const Model& model_;
  Value::Table table_;
  std::vector<double> standard_;  // the defaults
  std::size_t next_ = 0;
  bool comparing_ = false;
};

/// Writes members into an open object. Derive a writer for members that refer to others.
class MemberWriter {
 public:
  MemberWriter(JsonWriter& json, const Model& model) : json_(json), model_(model) {}
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const char* key, Number x, const Field& field) {
    if (x != field.left_out) json_.member(key, x);
  }
  void operator()(const char* key, const Vec3& x, const Field&) { json_.member(key, x); }
  void operator()(const char* key, const SpringEnd& end, const Field&) {
    json_.key(key).begin_object().member("body", model_.body_name(end.body)).member("point", end.point).end_object();
  }

 protected:
  JsonWriter& json_;
  const Model& model_;
};

/// Reads members of an object, in SI units. Absent ones keep their values. Derive a reader for members that refer to others.
class MemberReader {
 public:
  explicit MemberReader(Fields& fields) : fields_(fields) {}
  void operator()(const char* key, double& x, const Field& field) {
    const Value* const given = fields_.find(key);
    if (given == nullptr) return;
    x = field.unbounded && given->is_null() ? HUGE_VAL : fields_.real(key).value_or(x);
  }
  void operator()(const char* key, bool& x, const Field&) { x = fields_.boolean(key).value_or(x); }
  void operator()(const char* key, int& x, const Field&) { x = fields_.count(key).value_or(x); }

 protected:
  Fields& fields_;
};

}  // namespace momentree::io
