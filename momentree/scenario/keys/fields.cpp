#include <momentree/scenario/keys/fields.hpp>

#include <algorithm>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/mistakes/shapes.hpp>

namespace momentree::io {

Fields::Fields(const Value& table, std::string where, Diagnostics& out, const char* context)
    : table_(table), where_(std::move(where)), context_(context), out_(out) {
  if (!table.table())
    out.error(table.place, where_ + ": expected a table, found " + table.type_name(),
              documents() ? "" : cure_of_table(where_, table));
}

std::vector<const Mistake*> Fields::mistakes_for(const std::string& key) const {
  if (documents()) return {};
  return mistakes_of(context_ != nullptr ? context_ : std::string_view(where_), key);
}

Fields::Fields(const Value& table, const KeyTable& keys, Diagnostics& out, std::string where)
    : Fields(table, where.empty() ? keys.name : std::move(where), out, keys.name) {
  keys_ = &keys;
}

const Type& Fields::type_of(std::string_view key) const {
  const Key* described = keys_ != nullptr ? keys_->find(key) : nullptr;
  MT_REQUIRE(described != nullptr, "the table's description has the key");
  return described->type;
}

const std::vector<Fields::Alias>& Fields::aliases() const {
  if (aliases_) return *aliases_;
  aliases_.emplace();
  if (const Value::Table* entries = table_.table())
    for (const Value::Entry& entry : *entries) {
      if (more_keys_ != nullptr && std::find(more_keys_->begin(), more_keys_->end(), entry.key) != more_keys_->end()) continue;
      for (const Mistake* mistake : mistakes_for(entry.key))
        if (!table_.find(mistake->key)) aliases_->push_back({&entry, mistake});
    }
  return *aliases_;
}

const Value::Entry* Fields::entry_of(std::string_view key) const {
  if (const Value::Entry* entry = table_.find(key)) return entry;
  for (const Alias& alias : aliases())
    if (alias.mistake->key == key && alias.mistake->same) return alias.entry;
  return nullptr;
}

// True if an entry is a common mistake for the key; it is reported once.
bool Fields::report_alias(std::string_view key) {
  aliases();
  for (Alias& alias : *aliases_) {
    if (alias.mistake->key != key) continue;
    if (!alias.reported) report_unknown(*alias.entry, cure_of(*alias.mistake));
    for (Alias& same : *aliases_) same.reported = same.reported || same.entry == alias.entry;
    return true;
  }
  return false;
}

Place Fields::place_of(std::string_view key) const {
  const Value::Entry* entry = entry_of(key);
  return entry ? entry->value.place : table_.place;
}

const Value* Fields::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  const Value::Entry* entry = entry_of(key);
  if (entry && entry->key != key) report_alias(key);
  return entry ? &entry->value : nullptr;
}

std::string_view Fields::meant(const Value::Entry& entry) const {
  for (const std::string_view key : known_)
    if (entry.key == key) return key;
  for (const std::string_view key : known_)
    if (entry_of(key) == &entry) return key;
  return entry.key;
}

const Value* Fields::require(std::string_view key, std::string hint) {
  const Value* value = find(key);
  if (value || !table_.table() || report_alias(key)) return value;
  const Key* described = keys_ != nullptr && hint.empty() ? keys_->find(key) : nullptr;
  if (described != nullptr && described->required != nullptr) hint = described->required;
  out_.error(table_.place, where_ + " has no '" + std::string(key) + "'", std::move(hint));
  return nullptr;
}

std::optional<double> Fields::number(std::string_view key) { return number(key, type_of(key).dimension); }

// Reports a number that is out of the range of its key.
bool Fields::in_range(std::string_view key, double x) const {
  const Key* described = keys_ != nullptr ? keys_->find(key) : nullptr;
  const Range range = described != nullptr ? described->type.range : Range::any;
  if (range == Range::positive ? x > 0 : range == Range::any || x >= 0) return true;
  out_.error(place_of(key), std::string(key) + (range == Range::positive ? ": must be greater than 0" : ": must not be negative"),
             x == 0 ? cure_of_zero(keys_->name, key) : "");
  return false;
}

std::optional<double> Fields::number(std::string_view key, const Dimension& expected) {
  const Value* value = find(key);
  const auto read = value ? read_number(*value, expected, key, out_) : std::nullopt;
  return read && in_range(key, *read) ? read : std::nullopt;
}

std::optional<std::string> Fields::string(std::string_view key) {
  const Value* value = find(key);
  return value ? read_string(*value, key, out_) : std::nullopt;
}

std::optional<bool> Fields::boolean(std::string_view key, std::string hint) {
  const Value* value = find(key);
  if (!value) return {};
  if (const bool* b = value->boolean()) return *b;
  out_.error(value->place, std::string(key) + ": expected true or false, found " + value->type_name(), std::move(hint));
  return {};
}

std::optional<Vec3> Fields::vec3(std::string_view key) { return vec3(key, type_of(key).dimension); }

std::optional<Vec3> Fields::vec3(std::string_view key, const Dimension& expected) {
  const Value* value = find(key);
  const auto read = value ? read_vec3(*value, expected, key, out_) : std::nullopt;
  return read && in_range(key, std::min({read->x, read->y, read->z})) ? read : std::nullopt;
}

std::optional<int> Fields::count(std::string_view key) {
  const auto given = real(key);
  if (!given) return {};
  if (*given >= 0 && *given <= std::numeric_limits<int>::max() && *given == std::floor(*given)) return static_cast<int>(*given);
  out_.error(place_of(key), std::string(key) + ": expected a count");
  return {};
}

std::optional<double> Fields::real(std::string_view key) {
  const Value* value = find(key);
  return value ? read_real(*value, key, out_) : std::nullopt;
}

std::vector<double> Fields::reals(std::string_view key, std::size_t count) {
  const Value* value = find(key);
  return value ? read_reals(*value, count, key, out_) : std::vector<double>{};
}

std::optional<Pose> Fields::pose(std::string_view key) {
  const Value* value = find(key);
  return value ? read_pose(*value, key, out_) : std::nullopt;
}

bool Fields::later(std::initializer_list<std::string_view> keys, const char* hint) {
  bool any = false;
  for (const std::string_view key : keys) {
    later_.push_back(key);
    const Value::Entry* entry = table_.find(key);
    if (!entry) continue;
    any = true;
    not_supported_yet(entry->place, in_quotes(key), out_, hint);
  }
  return any;
}

void Fields::report_unknown(const Value::Entry& entry, std::string hint) {
  out_.error(entry.place, "unknown key " + in_quotes(entry.key) + " in " + where_, std::move(hint));
}

// The hint about what to write instead of an unknown key.
std::string Fields::hint_for(const Value::Entry& entry) const {
  const auto is_known = [this](std::string_view key) { return std::find(known_.begin(), known_.end(), key) != known_.end(); };
  for (const Mistake* mistake : mistakes_for(entry.key))
    if (*mistake->key == '\0' || is_known(mistake->key)) return cure_of(*mistake);
  std::string hint = did_you_mean(entry.key, {known_.begin(), known_.end()});
  if (!hint.empty()) return hint;
  hint = "known here:";
  for (const std::string_view key : known_) hint += " " + std::string(key);
  return hint;
}

void Fields::finish() {
  if (!table_.table()) return;
  const auto among = [](const std::vector<std::string_view>& keys, const std::string& key) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  for (const Value::Entry& entry : *table_.table()) {
    if (among(known_, entry.key) || among(later_, entry.key) || out_.full()) continue;
    const auto reported = [&entry](const Alias& alias) { return alias.entry == &entry && alias.reported; };
    if (aliases_ && std::any_of(aliases_->begin(), aliases_->end(), reported)) continue;
    report_unknown(entry, hint_for(entry));
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
