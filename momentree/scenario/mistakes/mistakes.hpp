#pragma once
// Common mistakes of users of other engines and formats, and hints about what to write instead, in one place.
#include <string>
#include <string_view>
#include <vector>

namespace momentree::io {

/// A key that is mistakenly written instead of another.
struct Mistake {
  const char* where;  ///< tables in which it is a mistake, separated by '|'; empty: wherever `key` is known
  const char* words;  ///< the mistaken keys, separated by spaces, in the form of plain_word()
  const char* key;    ///< the intended key; empty if there is none: `text` then gives the advice
  const char* text;   ///< an example of that key
  bool same = true;   ///< the value is also valid for that key
};

/// The mistakes for that word in that table, in the order in which they should be checked.
std::vector<const Mistake*> mistakes_of(std::string_view where, std::string_view word);
/// The hint: "write 'step', as in step = "1 ms"", or the advice.
std::string cure_of(const Mistake& mistake);

/// The hint for a joint kind, an integration method or a value of `root` that other engines know by another name; empty if
/// there is none.
std::string cure_of_kind(std::string_view word);
std::string cure_of_method(std::string_view word);
std::string cure_of_root(std::string_view word);
/// True for words that other engines use for the ground.
bool means_ground(std::string_view word);

/// All mistakes, for tests.
std::vector<const Mistake*> all_mistakes();

}  // namespace momentree::io
