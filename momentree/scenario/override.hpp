#pragma once
// `--set KEY=VALUE`: replaces or adds a value of a document before it is read.
#include <string>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

/// Applies the overrides in order. A key is a dotted path: tables of an array are found by their `name`, an event without a
/// name by #1, #2 …, entries of any array by their index from 0. Missing tables are added. The value is TOML, else a string.
void apply_overrides(Value& document, const std::vector<std::string>& overrides, Diagnostics& out);

/// The place in the document that the key of an override names: keys of tables and numbers of entries, whatever the override
/// calls them. Keys with equal places, or of which one place begins with the other, name the same value. Empty if it has no
/// such place yet, or another form.
std::vector<std::string> place_of_key(const Value& document, const std::string& key);

}  // namespace momentree::io
