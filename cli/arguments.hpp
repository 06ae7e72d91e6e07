#pragma once
// Values of options that are numbers. All throw Error for text that is not such a number, with an example.
#include <string>

namespace momentree::cli {

/// A time of at least 0: seconds, or a number with a unit ("2 min").
double seconds_argument(const char* option, const std::string& text);
/// The same as a value of a scenario.
std::string time_argument(const char* option, const std::string& text);
/// A whole number between two others.
int number_argument(const char* option, const std::string& text, int least, int most);

}  // namespace momentree::cli
