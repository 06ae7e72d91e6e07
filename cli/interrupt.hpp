#pragma once
// Ctrl-C and SIGTERM during a run: the first one ends the run at the next step, the second ends the program at once.

namespace momentree::cli {

/// Handles the signals during its lifetime. Guards within that of another one change nothing. Used by the main thread.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool interrupted();
};

}  // namespace momentree::cli
