#pragma once
// The keys of one table of a scenario: read with their types and units; what no reader asked for is unknown.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/units.hpp>
#include <momentree/base/value.hpp>
#include <momentree/io/diagnostic.hpp>
#include <momentree/io/mistakes/mistakes.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io {

/// These read one value, or report what is wrong with it under the name `label` and return nothing.
/// An angle without a unit that is more than a turn is a warning: it may be meant in degrees.
std::optional<double> read_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// The same without that warning, for values that turn on and on.
std::optional<double> read_plain_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
std::optional<std::string> read_string(const Value& value, std::string_view label, Diagnostics& out);
std::optional<Vec3> read_vec3(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// A table of xyz with rpy (fixed axes) or quat (w, x, y, z; normalised, refused if off by more than 1e-6).
std::optional<Pose> read_pose(const Value& value, std::string_view label, Diagnostics& out);
/// 1 number for all three moments, 3 principal ones, or 6: xx, yy, zz, xy, xz, yz.
std::optional<Sym3> read_inertia(const Value& value, std::string_view label, Diagnostics& out);

/// Reports what is still to come.
void not_supported_yet(Place place, std::string_view what, Diagnostics& out, std::string hint = {});

class Fields {
 public:
  /// `where` names the table in messages: "[integrate]". Reports a `table` that is not a table; it is then read as empty.
  /// `context`: the name under which mistakes/ knows it; null: `where`.
  Fields(const Value& table, std::string where, Diagnostics& out, const char* context = nullptr);

  Place place() const { return table_.place; }
  /// Of the value of a key; of the table where the key is absent.
  Place place_of(std::string_view key) const;
  /// Here as in find(), a key that is written by another name counts, too.
  bool has(std::string_view key) const { return entry_of(key) != nullptr; }
  /// The value of a key, null if it is absent. The key is known from now on. A value under a name that is a natural mistake for
  /// the key is reported, and returned.
  const Value* find(std::string_view key);
  /// The key that an entry of the table stands for: its own, or the one that it is a natural mistake for.
  std::string_view meant(const Value::Entry& entry) const;
  /// The same, but its absence is an error.
  const Value* require(std::string_view key, std::string hint = {});

  /// True where there is something that is a natural mistake for that key, which is then reported: its absence needs no more
  /// words.
  bool mistaken(std::string_view key) { return report_alias(key); }

  /// Typed: nothing where the key is absent, or where its value is wrong and was reported.
  std::optional<double> number(std::string_view key, const Dimension& expected);
  std::optional<double> positive(std::string_view key, const Dimension& expected);
  std::optional<double> not_negative(std::string_view key, const Dimension& expected);
  std::optional<std::string> string(std::string_view key);
  std::optional<bool> boolean(std::string_view key, std::string hint = {});
  std::optional<Vec3> vec3(std::string_view key, const Dimension& expected);
  std::optional<Pose> pose(std::string_view key);

  /// Keys that are known, but whose meaning is still to come: refused where they stand. True if there was one.
  bool later(std::initializer_list<std::string_view> keys, const char* hint = "");
  /// Keys without a reader are errors, with the nearest known key suggested. To be called last.
  void finish();

 private:
  struct Alias {
    const Value::Entry* entry;
    const Mistake* mistake;
    bool reported = false;
  };
  const std::vector<Alias>& aliases() const;
  const Value::Entry* entry_of(std::string_view key) const;
  bool report_alias(std::string_view key);
  void report_unknown(const Value::Entry& entry, std::string hint);
  std::string hint_for(const Value::Entry& entry) const;

  const Value& table_;
  std::string where_;
  const char* context_;
  Diagnostics& out_;
  std::vector<std::string_view> known_;                // keys are literals
  std::vector<std::string_view> later_;                // known, and still to come
  mutable std::optional<std::vector<Alias>> aliases_;  // entries that are natural mistakes; found once one is looked for
};

/// The tables of an array of tables, one `[[…]]` each; reports where the value is something else.
std::vector<const Value*> tables_of(const Value& value, std::string_view header, Diagnostics& out);

}  // namespace momentree::io
