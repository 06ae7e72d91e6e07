#pragma once
// A progress line for a run, on standard error.
#include <chrono>

namespace momentree::cli {

class Progress {
 public:
  /// Does nothing if `shown` is false (no terminal, --quiet).
  Progress(double start, double until, bool shown);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Call it after each step; draws at most ten times a second.
  void at(double time);
  /// Removes the line.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  double start_, until_;
  bool shown_, drawn_ = false;
  Clock::time_point began_, next_;
};

/// True where standard error is a terminal that can be drawn on.
bool errors_on_terminal();

}  // namespace momentree::cli
