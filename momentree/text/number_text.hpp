#pragma once
// Numbers as text that reads back to the same bits, in any locale.
#include <string>

namespace momentree::io {

/// Appends the shortest decimal text that reads back to the same bits; minus zero as "-0.0", which JSON readers keep. `value`
/// may be infinite or NaN ("inf", "nan"): JSON writers must check this first.
void append_number(std::string& text, double value);
void append_number(std::string& text, long value);

std::string number_text(double value);
/// With so many significant digits, for messages.
std::string rounded_text(double value, int digits);

}  // namespace momentree::io
