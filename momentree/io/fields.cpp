#include <momentree/io/fields.hpp>

#include <algorithm>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::io {

Fields::Fields(const Value& table, std::string where, Diagnostics& out) : table_(table), where_(std::move(where)), out_(out) {
  if (!table.table()) out.error(table.place, where_ + ": expected a table, found " + table.type_name());
}

Place Fields::place_of(std::string_view key) const {
  const Value::Entry* entry = table_.find(key);
  return entry ? entry->value.place : table_.place;
}

const Value* Fields::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  const Value::Entry* entry = table_.find(key);
  return entry ? &entry->value : nullptr;
}

const Value* Fields::require(std::string_view key, std::string hint) {
  const Value* value = find(key);
  if (!value && table_.table()) out_.error(table_.place, where_ + " has no '" + std::string(key) + "'", std::move(hint));
  return value;
}

std::optional<double> Fields::number(std::string_view key, const Dimension& expected) {
  const Value* value = find(key);
  return value ? read_number(*value, expected, key, out_) : std::nullopt;
}

std::optional<double> Fields::positive(std::string_view key, const Dimension& expected) {
  const auto number_read = number(key, expected);
  if (!number_read || *number_read > 0) return number_read;
  out_.error(place_of(key), std::string(key) + ": must be greater than 0");
  return {};
}

std::optional<double> Fields::not_negative(std::string_view key, const Dimension& expected) {
  const auto number_read = number(key, expected);
  if (!number_read || *number_read >= 0) return number_read;
  out_.error(place_of(key), std::string(key) + ": must not be negative");
  return {};
}

std::optional<std::string> Fields::string(std::string_view key) {
  const Value* value = find(key);
  return value ? read_string(*value, key, out_) : std::nullopt;
}

std::optional<bool> Fields::boolean(std::string_view key) {
  const Value* value = find(key);
  if (!value) return {};
  if (const bool* b = value->boolean()) return *b;
  out_.error(value->place, std::string(key) + ": expected true or false, found " + value->type_name());
  return {};
}

std::optional<Vec3> Fields::vec3(std::string_view key, const Dimension& expected) {
  const Value* value = find(key);
  return value ? read_vec3(*value, expected, key, out_) : std::nullopt;
}

std::optional<Pose> Fields::pose(std::string_view key) {
  const Value* value = find(key);
  return value ? read_pose(*value, key, out_) : std::nullopt;
}

bool Fields::later(std::initializer_list<std::string_view> keys, const char* hint) {
  bool any = false;
  for (const std::string_view key : keys) {
    known_.push_back(key);
    const Value::Entry* entry = table_.find(key);
    if (!entry) continue;
    any = true;
    not_supported_yet(entry->place, in_quotes(key), out_, hint);
  }
  return any;
}

void Fields::finish() {
  if (!table_.table()) return;
  for (const Value::Entry& entry : *table_.table()) {
    if (std::find(known_.begin(), known_.end(), entry.key) != known_.end() || out_.full()) continue;
    std::string hint = did_you_mean(entry.key, {known_.begin(), known_.end()});
    if (hint.empty()) {
      hint = "known here:";
      for (const std::string_view key : known_) hint += " " + std::string(key);
    }
    out_.error(entry.place, "unknown key " + in_quotes(entry.key) + " in " + where_, std::move(hint));
  }
}

void not_supported_yet(Place place, std::string_view what, Diagnostics& out, std::string hint) {
  out.error(place, std::string(what) + " is not supported yet", std::move(hint));
}

std::vector<const Value*> tables_of(const Value& value, std::string_view header, Diagnostics& out) {
  std::vector<const Value*> tables;
  const std::string name(header);
  if (const Value::Array* entries = value.array()) {
    for (const Value& entry : *entries) {
      if (entry.table())
        tables.push_back(&entry);
      else
        out.error(entry.place, "expected tables [[" + name + "]], found " + entry.type_name());
    }
  } else {
    out.error(value.place, "expected tables [[" + name + "]], found " + value.type_name(),
              value.table() ? "write [[" + name + "]]: there may be several" : "");
  }
  return tables;
}

}  // namespace momentree::io
