#pragma once
// Writes a document as readable TOML: tables under headers, keys on single lines, one blank line between blocks.
#include <string>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// The key of an entry that is a comment: its string is written above the table's header.
inline constexpr const char* comment_key = "#";

/// A scenario's document as text: `[world]`, `[[mechanism.body]]` and the like become headers, all other tables are written
/// inline. Numbers read back to the same bits; minus zero is written as zero. Scenarios have no dates; such values are left
/// out.
std::string toml_text(const Value& document);

/// One value as it is written after `key = `.
std::string toml_value_text(const Value& value);

}  // namespace momentree::io
