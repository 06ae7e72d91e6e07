#pragma once
// Parsers of option values. All throw Error, with an example, for other text.
#include <string>
#include <vector>

namespace momentree::cli {

/// A time of at least 0, in s: a number of seconds, or a number with a unit ("2 min").
double seconds_argument(const char* option, const std::string& text);
/// The same, more than 0.
double interval_argument(const char* option, const std::string& text);
/// The same time as the text of a scenario value.
std::string time_argument(const char* option, const std::string& text);
/// A number of at least 0.
double tolerance_argument(const char* option, const std::string& text);
/// A whole number in [least, most].
int number_argument(const char* option, const std::string& text, int least, int most);
/// One of these words.
std::string choice_argument(const char* option, const std::string& text, const std::vector<std::string>& choices);

}  // namespace momentree::cli
