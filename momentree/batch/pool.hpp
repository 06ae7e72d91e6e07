#pragma once
// Threads that share out numbered tasks.
#include <functional>
#include <memory>

namespace momentree::batch {

class Pool {
 public:
  /// `threads` of them do the work, the caller's among them.
  explicit Pool(int threads);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int threads() const;
  /// Calls task(thread, i) for every i below `count`, each once, and returns when all are done. `thread` says which of threads()
  /// it is. Must not throw.
  void run(int count, const std::function<void(int thread, int i)>& task) noexcept;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace momentree::batch
