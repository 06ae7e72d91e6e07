#pragma once
// Problems of files as editors take them.
#include <momentree/io/diagnostic.hpp>
#include <momentree/io/json_writer.hpp>

namespace momentree::io {

/// { severity, message, hint, file, line, column, end_line, end_column }: lines and columns count from 1, columns in characters;
/// the end is the column after the last character. What is not known is null.
void write_diagnostic(JsonWriter& json, const Diagnostic& diagnostic);

/// The column after the key, the value or the tag that begins at `column` of a line, as far as the line shows it; 0: not known.
int end_column(std::string_view line, int column);

}  // namespace momentree::io
