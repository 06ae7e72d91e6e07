#include <tests/fuzz/same_text.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include <tests/fuzz/traced_run.hpp>

namespace momentree::fuzz {

namespace {

// Documents store quaternions with positive w; negating one gives its zeros a sign, which is removed here.
std::string without_signs_of_zeros(std::string text) {
  for (std::size_t at = 0; (at = text.find("-0.0", at)) != std::string::npos; ++at)
    if (at + 4 == text.size() || std::strchr("0123456789", text[at + 4]) == nullptr) text.replace(at, 4, "0");
  return text;
}

// The content of a document is independent of the order of its joints, which is by joint number: one line each.
std::string in_any_order(const std::string& document) {
  std::vector<std::string> all;
  std::istringstream in(document);
  for (std::string line; std::getline(in, line);) all.push_back(line.ends_with(',') ? line.substr(0, line.size() - 1) : line);
  std::sort(all.begin(), all.end());
  return rendered(all);
}

// Texts that differ at most by rounding errors of the numbers in them, of which those before in a line are of one size.
bool same_but_for_rounding(const std::string& one, const std::string& other) {
  double largest = 1;
  const char *a = one.c_str(), *b = other.c_str();
  const auto begins_number = [](const char* at) {
    return std::isdigit(static_cast<unsigned char>(*at)) != 0 ||
           (*at == '-' && std::isdigit(static_cast<unsigned char>(at[1])) != 0);
  };
  while (*a != 0 && *b != 0) {
    if (*a == '\n') largest = 1;
    if (!begins_number(a) || !begins_number(b)) {
      if (*a++ != *b++) return false;
      continue;
    }
    char *after_a = nullptr, *after_b = nullptr;
    const double x = std::strtod(a, &after_a), y = std::strtod(b, &after_b);
    largest = std::max({largest, std::fabs(x), std::fabs(y)});
    if (!(std::fabs(x - y) <= std::max(1e-9 * std::max({1.0, std::fabs(x), std::fabs(y)}), 1e-13 * largest))) return false;
    a = after_a, b = after_b;
  }
  return *a == *b;
}

}  // namespace

std::string rendered(const std::vector<std::string>& list) {
  std::string all;
  for (const std::string& each : list) all += each + "\n";
  return all;
}

void require_same(std::string one, std::string other, const std::string& law, Findings& found) {
  if (one == other) return;
  one = without_signs_of_zeros(std::move(one)), other = without_signs_of_zeros(std::move(other));
  if (one != other) found.require(false, law, "\n" + difference(one, other));
}

void require_same_document(const std::string& one, const std::string& other, const std::string& law, Findings& found) {
  if (one == other) return;
  const std::string first = in_any_order(one), second = in_any_order(other);
  if (one.find("\"loop\": true") == std::string::npos || !same_but_for_rounding(first, second))
    require_same(first, second, law, found);
}

}  // namespace momentree::fuzz
