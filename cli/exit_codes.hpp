#pragma once
namespace momentree::cli {
/// Exit codes of the program: done, the simulation (or writing its results) failed, bad input or usage, interrupted.
enum ExitCode : int { done = 0, failed = 1, bad_input = 2, interrupted = 3 };
}  // namespace momentree::cli
