#include <momentree/base/wildcard.hpp>

#include <cstddef>
#include <string>

namespace momentree {

// Backtracks to at most two positions: linear in practice, never recursive.
bool matches_wildcard(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, star_n = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, star_n = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != std::string_view::npos && name[star_n] != '/') {
      p = star + 1, n = ++star_n;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

bool names_body(std::string_view name, std::string_view body) {
  return matches_wildcard(name, body) || matches_wildcard(std::string(name) + "/*", body);
}

}  // namespace momentree
