#pragma once
// Diagnostics as JSON, for editors.
#include <momentree/text/diagnostic.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

/// { severity, message, hint, file, line, column, end_line, end_column }. Lines and columns count from 1, and columns count
/// characters; the end is the column after the last character. Unknown values are null.
void write_diagnostic(JsonWriter& json, const Diagnostic& diagnostic);

/// The column after the key, value or tag that begins at `column` of a line, as far as the line shows it; 0 if unknown.
int end_column(std::string_view line, int column);

}  // namespace momentree::io
