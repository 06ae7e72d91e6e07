#pragma once
// The manual page, generated from the table of commands and options.
#include <string>

#include <cli/command_line.hpp>

namespace momentree::cli {

/// momentree(1) as troff text, with the macros of man(7).
std::string man_page(const CommandTable& table);

}  // namespace momentree::cli
