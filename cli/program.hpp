#pragma once
// The whole program, from the arguments of main to the exit code: the command, and `python -m momentree`.
#include <string_view>

#include <cli/commands.hpp>

namespace momentree::cli {

/// Runs the command line and turns errors into messages and exit codes. `bench`: that command; `commit`: of what sources the
/// program is made, empty if that is not known.
int program(int argc, char** argv, Bench bench, std::string_view commit);

}  // namespace momentree::cli
