#pragma once
// A document as a tree of values with their locations: the input of scenario readers, whatever the file's syntax.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace momentree {

/// Location of a value: line and column from 1 (columns count characters, not bytes) in the file or, if `option` > 0, in the
/// option-th override on the command line.
struct Place {
  int line = 0, column = 0, option = 0;
  friend bool operator==(const Place&, const Place&) = default;
};

class Value {
 public:
  struct Entry;
  using Array = std::vector<Value>;
  using Table = std::vector<Entry>;  ///< in the order of the file
  /// A date or a time of day; no field accepts one. Its copy constructor is not trivial so that the variant can be valueless:
  /// after an out-of-memory copy, libstdc++ 12 destroys a variant that can never be valueless as if it had a value.
  struct Time {
    Time() = default;
    Time(const Time&) noexcept {}
    Time& operator=(const Time&) noexcept { return *this; }
  };

  /// The `null` of JSON; only few fields accept it.
  struct Null {};

  /// An empty table without a location.
  Value();
  template <class T>
  Value(T data, Place place_) : place(place_), data_(std::move(data)) {}

  Place place;

  const bool* boolean() const { return std::get_if<bool>(&data_); }
  const std::int64_t* integer() const { return std::get_if<std::int64_t>(&data_); }
  const double* real() const { return std::get_if<double>(&data_); }
  /// An integer or a real number.
  std::optional<double> number() const;
  const std::string* string() const { return std::get_if<std::string>(&data_); }
  const Array* array() const { return std::get_if<Array>(&data_); }
  const Table* table() const { return std::get_if<Table>(&data_); }
  Array* array() { return std::get_if<Array>(&data_); }
  Table* table() { return std::get_if<Table>(&data_); }
  bool is_null() const { return std::holds_alternative<Null>(data_); }
  /// True for an array with at least one entry, all of them tables.
  bool is_array_of_tables() const;
  /// The entry of a table; null if there is none, or if this is not a table.
  const Entry* find(std::string_view key) const;
  Entry* find(std::string_view key) { return const_cast<Entry*>(std::as_const(*this).find(key)); }
  /// For messages: "a number", "a string", "a list" …
  const char* type_name() const;

 private:
  std::variant<bool, std::int64_t, double, std::string, Array, Table, Time, Null> data_;
};

struct Value::Entry {
  std::string key;
  Place place;  ///< of the key; the value has its own
  Value value;
};

inline Value::Value() : data_(Table{}) {}

inline const Value::Entry* Value::find(std::string_view key) const {
  if (const Table* entries = table())
    for (const Entry& entry : *entries)
      if (entry.key == key) return &entry;
  return nullptr;
}

inline std::optional<double> Value::number() const {
  if (const std::int64_t* n = integer()) return static_cast<double>(*n);
  if (const double* x = real()) return *x;
  return {};
}

inline bool Value::is_array_of_tables() const {
  const Array* entries = array();
  if (!entries || entries->empty()) return false;
  for (const Value& entry : *entries)
    if (!entry.table()) return false;
  return true;
}

inline const char* Value::type_name() const {
  static constexpr const char* names[] = {"true or false", "a number", "a number",       "a string",
                                          "a list",        "a table",  "a date or time", "null"};
  return names[data_.index()];
}

}  // namespace momentree
