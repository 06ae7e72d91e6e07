#pragma once
// Threads that share numbered tasks.
#include <functional>
#include <memory>

namespace momentree::batch {

class Pool {
 public:
  /// `threads` threads in total, including the caller's.
  explicit Pool(int threads);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int threads() const;
  /// Calls task(thread, i) once for every i below `count`, and returns when all are done. `thread` is the number of the executing
  /// thread, below threads(). Tasks must not throw.
  void run(int count, const std::function<void(int thread, int i)>& task) noexcept;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace momentree::batch
