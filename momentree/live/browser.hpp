#pragma once
// Addresses of pages on this machine, and the user's browser.
#include <string>

namespace momentree::live {

/// 128 random bits in hexadecimal digits.
std::string random_key();

/// Whether the user has a screen on which a browser could open.
bool has_screen();

/// Opens the address in the user's browser; failures are ignored.
void open_in_browser(const std::string& address);

}  // namespace momentree::live
