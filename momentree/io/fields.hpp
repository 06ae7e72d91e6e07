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
#include <momentree/math/vec.hpp>

namespace momentree::io {

/// These read one value, or report what is wrong with it under the name `label` and return nothing.
std::optional<double> read_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
std::optional<std::string> read_string(const Value& value, std::string_view label, Diagnostics& out);
std::optional<Vec3> read_vec3(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
/// A table of xyz with rpy (fixed axes) or quat (w, x, y, z; normalised, refused if off by more than 1e-6).
std::optional<Pose> read_pose(const Value& value, std::string_view label, Diagnostics& out);
/// 1 number for all three moments, 3 principal ones, or 6: xx, yy, zz, xy, xz, yz.
std::optional<Sym3> read_inertia(const Value& value, std::string_view label, Diagnostics& out);

/// Reports that something of the contract is still to come.
void not_supported_yet(Place place, std::string_view what, Diagnostics& out, std::string hint = {});

class Fields {
 public:
  /// `where` names the table in messages: "[integrate]". Reports if `table` is none; it is then read as empty.
  Fields(const Value& table, std::string where, Diagnostics& out);

  Place place() const { return table_.place; }
  /// Of the value of a key; of the table where the key is absent.
  Place place_of(std::string_view key) const;
  bool has(std::string_view key) const { return table_.find(key) != nullptr; }
  /// The value of a key, null if it is absent. The key is known from now on.
  const Value* find(std::string_view key);
  /// The same, but its absence is an error.
  const Value* require(std::string_view key, std::string hint = {});

  /// Typed: nothing where the key is absent, or where its value is wrong and was reported.
  std::optional<double> number(std::string_view key, const Dimension& expected);
  std::optional<double> positive(std::string_view key, const Dimension& expected);
  std::optional<double> not_negative(std::string_view key, const Dimension& expected);
  std::optional<std::string> string(std::string_view key);
  std::optional<bool> boolean(std::string_view key);
  std::optional<Vec3> vec3(std::string_view key, const Dimension& expected);
  std::optional<Pose> pose(std::string_view key);

  /// Keys that are known, but whose meaning is still to come: refused where they stand. True if there was one.
  bool later(std::initializer_list<std::string_view> keys, const char* hint = "");
  /// Keys without a reader are errors, with the nearest known key suggested. To be called last.
  void finish();

 private:
  const Value& table_;
  std::string where_;
  Diagnostics& out_;
  std::vector<std::string_view> known_;  // keys are literals
};

/// The tables of an array of tables, one `[[…]]` each; reports where the value is something else.
std::vector<const Value*> tables_of(const Value& value, std::string_view header, Diagnostics& out);

}  // namespace momentree::io
