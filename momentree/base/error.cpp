#include <momentree/base/error.hpp>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <momentree/base/characters.hpp>
#include <momentree/base/edit_distance.hpp>

#if defined(__wasm__) && !defined(__cpp_exceptions)
// Throws in the host of the module.
extern "C" [[noreturn]] __attribute__((import_module("momentree"), import_name("fail"))) void momentree_fail(const char* message,
                                                                                                             std::size_t length);
#endif

namespace momentree {

Error::Error(std::string the_problem, std::string the_place, std::string the_hint)
    : problem(std::move(the_problem)), where(std::move(the_place)), hint(std::move(the_hint)), line_(message()) {}

Error::Error(std::string the_problem, std::string the_place, std::string the_hint, std::string the_line)
    : problem(std::move(the_problem)), where(std::move(the_place)), hint(std::move(the_hint)), line_(std::move(the_line)) {}

const char* Error::what() const noexcept { return line_.c_str(); }

std::string Error::message() const {
  std::string text = where.empty() ? "error: " : printable(where) + ": error: ";
  text += printable(problem);
  if (!hint.empty()) text += "; " + printable(hint);
  return text;
}

void throw_error(Error error) {
#if defined(__cpp_exceptions)
  throw Error(std::move(error));
#elif defined(__wasm__)
  const std::string message = error.message();
  momentree_fail(message.data(), message.size());
#else
  (void)error;
  std::abort();
#endif
}

// Damerau–Levenshtein distance (optimal string alignment): a swap of neighbours counts as one edit.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> before(width), last(width), row(width);
  for (std::size_t j = 0; j < width; ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j < width; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::string plain_word(std::string_view word) {
  std::string plain;
  for (const char c : word)
    if (c != '_' && c != '-' && c != ' ') plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return plain;
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  if (word.size() > 200) return {};
  const std::string plain = plain_word(word);
  for (const std::string& candidate : known)
    if (!plain.empty() && candidate.size() <= 200 && candidate != word && plain_word(candidate) == plain) return candidate;
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;  // nearly everything is close to a short word
  for (const std::string& candidate : known) {
    if (candidate.size() > 200) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < word.size()) best = candidate, best_distance = distance;
  }
  return best;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  const std::string best = nearest(word, known);
  return best.empty() ? std::string{} : "did you mean '" + best + "'?";
}

}  // namespace momentree
