#pragma once
// Ctrl-C and SIGTERM while a run goes on: the first asks it to end at the next step, the second ends the program at once.

namespace momentree::cli {

/// Listens as long as it lives.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool interrupted();
};

}  // namespace momentree::cli
