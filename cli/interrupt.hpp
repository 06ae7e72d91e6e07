#pragma once
// Ctrl-C and SIGTERM during a run: the first one ends the run at the next step, the second ends the program at once.

namespace momentree::cli {

/// Handles the signals during its lifetime.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool interrupted();
};

}  // namespace momentree::cli
