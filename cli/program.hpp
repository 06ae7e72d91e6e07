#pragma once
// The whole program, from the arguments of main to the exit code: the command, and `python -m momentree`.
#include <cli/commands.hpp>

namespace momentree::cli {

/// Runs the command line and turns errors into messages and exit codes. `bench`: that command.
int program(int argc, char** argv, Bench bench);

}  // namespace momentree::cli
