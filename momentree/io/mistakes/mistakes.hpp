#pragma once
// What people write who know other engines and formats, and what to write here: the cures of natural mistakes, in one place.
#include <string>
#include <string_view>
#include <vector>

namespace momentree::io {

/// A key that is written in the place of another.
struct Mistake {
  const char* where;  ///< tables in which it is one, separated by '|'; empty: wherever `key` is known
  const char* words;  ///< what is written, separated by spaces, as plain_word() has it
  const char* key;    ///< the key that is meant; empty if there is no such key; `text` then says what to do
  const char* text;   ///< an example of that key
  bool same = true;   ///< the value is one of that key, too
};

/// Mistakes of that word in that table, in the order in which they are to be looked at.
std::vector<const Mistake*> mistakes_of(std::string_view where, std::string_view word);
/// "write 'step', as in step = "1 ms"", or the advice.
std::string cure_of(const Mistake& mistake);

/// The cure for a kind of joint, a method of integration or a way to hold a root that other engines know by another name; empty:
/// none is known.
std::string cure_of_kind(std::string_view word);
std::string cure_of_method(std::string_view word);
std::string cure_of_root(std::string_view word);
/// True for what others call the ground.
bool means_ground(std::string_view word);

/// All of them, for tests.
std::vector<const Mistake*> all_mistakes();

}  // namespace momentree::io
