#include <momentree/batch/pool.hpp>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace momentree::batch {

struct Pool::Shared {
  std::mutex mutex;
  std::condition_variable start, finish;
  const std::function<void(int, int)>* task = nullptr;
  std::atomic<int> next{0};
  int count = 0, busy = 0;
  unsigned round = 0;
  bool over = false;
  std::vector<std::thread> helpers;

  void work(int thread) {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) (*task)(thread, i);
  }
  void help(int thread) {
    unsigned seen = 0;
    std::unique_lock lock(mutex);
    for (;;) {
      start.wait(lock, [&] { return over || round != seen; });
      if (over) return;
      seen = round;
      lock.unlock();
      work(thread);
      lock.lock();
      if (--busy == 0) finish.notify_one();
    }
  }
};

Pool::Pool(int threads) : shared_(std::make_unique<Shared>()) {
  for (int i = 1; i < threads; ++i) shared_->helpers.emplace_back([shared = shared_.get(), i] { shared->help(i); });
}

Pool::~Pool() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->over = true;
  }
  shared_->start.notify_all();
  for (std::thread& helper : shared_->helpers) helper.join();
}

int Pool::threads() const { return static_cast<int>(shared_->helpers.size()) + 1; }

void Pool::run(int count, const std::function<void(int, int)>& task) noexcept {
  Shared& s = *shared_;
  if (s.helpers.empty() || count < 2) {
    for (int i = 0; i < count; ++i) task(0, i);
    return;
  }
  {
    const std::lock_guard lock(s.mutex);
    s.task = &task, s.count = count, s.next = 0;
    s.busy = static_cast<int>(s.helpers.size());
    ++s.round;
  }
  s.start.notify_all();
  s.work(0);
  std::unique_lock lock(s.mutex);
  s.finish.wait(lock, [&] { return s.busy == 0; });
}

}  // namespace momentree::batch
