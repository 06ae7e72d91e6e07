#pragma once
#include <string>
#include <string_view>

namespace momentree {

/// A line of text as it may stand in a comment of generated code, whatever reads that code: printable ASCII as it is, anything
/// else by its number, <U+000D> a character and <0xFF> a byte that is none. So are characters that could end the comment or go on
/// with it on the next line: backslashes, question marks in pairs (trigraphs), and the second character of /* and */.
std::string comment_text(std::string_view line);

/// Lines as comments, each behind //.
std::string comment(std::string_view lines);

}  // namespace momentree
