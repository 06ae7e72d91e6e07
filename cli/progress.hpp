#pragma once
// A line on standard error that says how far a run has come.
#include <chrono>

namespace momentree::cli {

class Progress {
 public:
  /// `shown` false (no terminal, --quiet): does nothing.
  Progress(double start, double until, bool shown);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After each step; draws at most ten times a second.
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
