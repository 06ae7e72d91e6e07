#pragma once
// Reads the keys of one scenario table with their types and units. Keys that no reader requests are unknown.
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/units.hpp>
#include <momentree/base/value.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/scenario/keys/keys.hpp>
#include <momentree/scenario/mistakes/mistakes.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

/// These functions read one value, or report under the name `label` what is wrong with it and return nothing. An angle without
/// a unit that exceeds one turn gives a warning, since it may be meant in degrees.
std::optional<double> read_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// Like read_number, but without that warning, for angles that may exceed one turn.
std::optional<double> read_plain_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// Nothing, with a report, for anything but a whole number from `least` to `most`.
std::optional<std::int64_t> read_whole(const Value& value, std::string_view label, std::int64_t least, std::int64_t most,
                                       Diagnostics& out);
std::optional<std::string> read_string(const Value& value, std::string_view label, Diagnostics& out);
std::optional<Vec3> read_vec3(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// A table of xyz (m) with rpy (fixed axes) or quat (w, x, y, z; normalised, an error if its length is off by more than 1e-6).
std::optional<Pose> read_pose(const Value& value, std::string_view label, Diagnostics& out);
/// Moments of inertia: 1 number for all three, 3 principal moments, or 6: xx, yy, zz, xy, xz, yz.
std::optional<Sym3> read_inertia(const Value& value, std::string_view label, Diagnostics& out);

/// A number without a unit, as in a JSON document.
std::optional<double> read_real(const Value& value, std::string_view label, Diagnostics& out);
/// A list of `count` such numbers; empty, with a report, if it is something else.
std::vector<double> read_reals(const Value& value, std::size_t count, std::string_view label, Diagnostics& out);

/// The entries of a list or a table; empty, with a report, if it is something else.
const Value::Array& read_list(const Value& value, std::string_view label, Diagnostics& out);
const Value::Table& read_table(const Value& value, std::string_view label, Diagnostics& out);

/// Reports an error: `what` is not supported yet.
void not_supported_yet(Place place, std::string_view what, Diagnostics& out, std::string hint = {});

class Fields {
 public:
  /// `where` names the table in messages: "[integrate]". If `table` is not a table, reports that and reads it as empty.
  /// `context`: the name of the table in mistakes/; null: `where`; empty: without common mistakes, for JSON documents.
  Fields(const Value& table, std::string where, Diagnostics& out, const char* context = nullptr);
  /// A table with a description. `where`: its name in messages; empty: that of the description.
  Fields(const Value& table, const KeyTable& keys, Diagnostics& out, std::string where = {});

  Place place() const { return table_.place; }
  /// The place of a key's value, or of the table if the key is absent.
  Place place_of(std::string_view key) const;
  /// As in find(), a key that is written under a mistaken name counts, too.
  bool has(std::string_view key) const { return entry_of(key) != nullptr; }
  /// The value of a key, or null if it is absent. The key is known from now on. A value under a name that is a common mistake
  /// for the key is reported, and still returned.
  const Value* find(std::string_view key);
  /// The key that an entry of the table stands for: its own, or the key for which it is a common mistake.
  std::string_view meant(const Value::Entry& entry) const;
  /// Like find(), but a missing key is an error. The hint for it is that of the description, unless another one is given.
  const Value* require(std::string_view key, std::string hint = {});

  /// More keys of this table, in addition to those of its description: they are never mistakes for others. Call it first.
  void not_mistakes(const std::vector<std::string>& keys) { more_keys_ = &keys; }
  /// True if the table contains a common mistake for that key, which is then reported: the missing key needs no further
  /// message.
  bool mistaken(std::string_view key) { return report_alias(key); }

  /// Typed values: nothing if the key is absent, or if its value is wrong and was reported. Without a dimension: the one of the
  /// key's description. Its range always holds.
  std::optional<double> number(std::string_view key);
  std::optional<double> number(std::string_view key, const Dimension& expected);
  std::optional<std::string> string(std::string_view key);
  std::optional<bool> boolean(std::string_view key, std::string hint = {});
  std::optional<Vec3> vec3(std::string_view key);
  std::optional<Vec3> vec3(std::string_view key, const Dimension& expected);
  std::optional<Pose> pose(std::string_view key);
  std::optional<double> real(std::string_view key);
  std::optional<int> count(std::string_view key);
  std::vector<double> reals(std::string_view key, std::size_t count);

  /// Known keys that are not supported yet: each one present is an error. True if there was one.
  bool later(std::initializer_list<std::string_view> keys, const char* hint = "");
  /// Reports unknown keys as errors, and suggests the nearest known key. Call it last.
  void finish();

 private:
  struct Alias {
    const Value::Entry* entry;
    const Mistake* mistake;
    bool reported = false;
  };
  bool documents() const { return context_ != nullptr && *context_ == '\0'; }
  std::vector<const Mistake*> mistakes_for(const std::string& key) const;
  const std::vector<Alias>& aliases() const;
  const Value::Entry* entry_of(std::string_view key) const;
  bool report_alias(std::string_view key);
  void report_unknown(const Value::Entry& entry, std::string hint);
  std::string hint_for(const Value::Entry& entry) const;
  const Type& type_of(std::string_view key) const;
  bool in_range(std::string_view key, double x) const;

  const Value& table_;
  std::string where_;
  const char* context_;
  const KeyTable* keys_ = nullptr;  // its description
  const std::vector<std::string>* more_keys_ = nullptr;
  Diagnostics& out_;
  std::vector<std::string_view> known_;                // the keys are literals
  std::vector<std::string_view> later_;                // known, but not supported yet
  mutable std::optional<std::vector<Alias>> aliases_;  // entries that are common mistakes; computed on first use
};

/// The tables of an array of tables, one `[[…]]` each; reports an error if the value is something else.
std::vector<const Value*> tables_of(const Value& value, std::string_view header, Diagnostics& out);

}  // namespace momentree::io
