#pragma once
#include <string>
#include <string_view>

namespace momentree {

/// A line of text in a form that is safe in a comment of generated code for any compiler: printable ASCII is kept, anything else
/// is replaced by its number, <U+000D> for a character and <0xFF> for an invalid byte. This includes characters that could end
/// the comment or continue it on the next line: backslashes, question marks in pairs (trigraphs), and the second character of /*
/// and */.
std::string comment_text(std::string_view line);

/// Lines as comments, each prefixed by //.
std::string comment(std::string_view lines);

}  // namespace momentree
