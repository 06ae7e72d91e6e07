#pragma once
// Descriptions of the tables of scenario files, as data next to their readers. The readers take units, ranges and hints from
// them; `momentree schema` writes them as a JSON Schema.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/units.hpp>
#include <momentree/base/value.hpp>
#include <momentree/scenario/keys/joint_keys.hpp>

namespace momentree::io {

struct KeyTable;

/// The values that a key accepts.
struct Type {
  enum class Form {
    text,
    boolean,
    number,   ///< or a string with a unit
    vector,   ///< three of them
    signals,  ///< three numbers or signals
    choice,   ///< one of the words
    table,    ///< with `keys`
    other     ///< as the schema says
  };
  Form form = Form::text;
  Dimension dimension{};                             ///< number, vector, signals
  Range range = Range::any;                          ///< number, each of a vector
  const char* unit = nullptr;                        ///< number: the unit, if it depends on the joint, as in "rad or m"
  const char* words = nullptr;                       ///< choice: separated by '|'
  std::vector<std::string> (*registry)() = nullptr;  ///< choice: the source of the words, if other code defines them
  const KeyTable* keys = nullptr;
  const char* schema = nullptr;  ///< other: JSON; '@' stands for the schema of `keys`
};

namespace type {
inline constexpr Type string{}, boolean{.form = Type::Form::boolean};
constexpr Type number(const Dimension& dimension, Range range = Range::any) {
  return {.form = Type::Form::number, .dimension = dimension, .range = range};
}
/// The reader determines the dimension.
constexpr Type number(const char* unit, Range range = Range::any) {
  return {.form = Type::Form::number, .range = range, .unit = unit};
}
constexpr Type vector(const Dimension& dimension, Range range = Range::any) {
  return {.form = Type::Form::vector, .dimension = dimension, .range = range};
}
constexpr Type signals(const Dimension& dimension) { return {.form = Type::Form::signals, .dimension = dimension}; }
constexpr Type choice(const char* words) { return {.form = Type::Form::choice, .words = words}; }
constexpr Type choice(std::vector<std::string> (*registry)()) { return {.form = Type::Form::choice, .registry = registry}; }
constexpr Type table(const KeyTable& keys) { return {.form = Type::Form::table, .keys = &keys}; }
constexpr Type other(const char* schema) { return {.form = Type::Form::other, .schema = schema}; }
constexpr Type other(const char* schema, const KeyTable& keys) {
  return {.form = Type::Form::other, .keys = &keys, .schema = schema};
}
/// Moments of inertia: 1, 3 or 6 numbers.
inline constexpr Type moments = other(R"({"anyOf": [{"type": ["number", "string"]},
  {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 1, "maxItems": 1},
  {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 3, "maxItems": 3},
  {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 6, "maxItems": 6}]})");
constexpr Type tables(const KeyTable& keys) { return other(R"({"type": "array", "items": @})", keys); }
constexpr Type one_or_several(const KeyTable& keys) {
  return other(R"({"anyOf": [@, {"type": "array", "items": @, "minItems": 1}]})", keys);
}
}  // namespace type

struct Key {
  const char* name;
  Type type;
  const char* about;                   ///< its meaning, for editors; the schema adds the unit
  const char* standard = nullptr;      ///< the default value, as JSON
  const char* required = nullptr;      ///< for a key that must be given: the hint if it is missing, which may be empty
  bool KindInfo::*of_kinds = nullptr;  ///< for a key that only some kinds of joint have
  const char* absent = nullptr;        ///< the default in words, where `standard` cannot say it
};

/// Keys of which a table must have exactly one, at least one, or at most one.
struct KeyRule {
  enum class How { none, one, some, not_two };
  How how = How::none;
  const char* keys = "";  ///< separated by spaces
};

using KeyList = std::span<const Key>;

struct KeyTable {
  const char* name;        ///< in messages: "[integrate]"; also selects the common mistakes
  const char* definition;  ///< its name in the schema, if it occurs more than once or is large; empty: written in place
  const char* about;
  KeyList own = {};
  KeyRule rules[2] = {};
  const KeyList* shared[2] = {};     ///< keys that other tables have as well
  bool parameters = false;           ///< it also has the parameters of a joint, joint_keys()
  KeyList (*described)() = nullptr;  ///< those of a described type: keys_of()
  const char* details = "";          ///< of an element: more about it, for docstrings

  /// Calls a function with each key.
  void each(auto visit) const {
    for (const Key& key : own) visit(key);
    if (described != nullptr)
      for (const Key& key : described()) visit(key);
    for (const KeyList* list : shared)
      for (const Key& key : list != nullptr ? *list : KeyList()) visit(key);
  }

  /// Null if it does not have that key.
  const Key* find(std::string_view key) const {
    const Key* found = nullptr;
    each([&](const Key& candidate) {
      if (candidate.name == key) found = &candidate;
    });
    return found;
  }
};

/// The tables, each defined next to its reader. `scenario_table` is the whole file.
extern const KeyTable scenario_table, world_table, integrate_table, output_table, mechanism_table, chain_table, body_table,
    shape_table, ground_shape_table, joint_table, joint_override_table, joint_start_table, placement_table, force_table,
    spring_table, cable_table, loop_table, coupling_table, mimic_table, contact_table, floor_table, belt_table, event_table,
    condition_table, point_table;
struct Reading;
/// The tables of elements between bodies or joints, such as spring_table, and their readers.
struct ElementTable {
  const KeyTable* keys;
  void (*read)(const Value& table, Reading& reading);
};
std::span<const ElementTable> element_tables();
/// Kind, axis, axis2 and pitch; and the initial values.
extern const KeyList joint_geometry, joint_starts;
/// The geometry of a joint that closes a loop.
extern const KeyList loop_geometry;

}  // namespace momentree::io
