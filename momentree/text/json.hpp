#pragma once
// JSON text as values with their lines and columns. The parser itself is in json.cpp alone.
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// The document; numbers read back to the bits that were written. Throws Error, `file:line:col`, at the first mistake: syntax, a
/// number too large for a double, a duplicate key, nesting deeper than 64. Its message does not quote the text, since any file
/// may be named as a document.
Value parse_json(std::string_view text, const std::string& file);

}  // namespace momentree::io
