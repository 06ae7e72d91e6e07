#pragma once
// A document as TOML that people read: tables under headers, keys in line, one blank line between blocks.
#include <string>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// The key of an entry that is no key: its string stands as a comment above the table's header.
inline constexpr const char* comment_key = "#";

/// A scenario's document: `[world]`, `[[mechanism.body]]` and the like become headers, all other tables stand in line. Numbers
/// read back to the same bits; minus zero is written as zero. Values of dates are none of a scenario's, and are left out.
std::string toml_text(const Value& document);

}  // namespace momentree::io
