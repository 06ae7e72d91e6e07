#include <momentree/batch/pool.hpp>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>

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

  void end() {
    {
      const std::lock_guard lock(mutex);
      over = true;
    }
    start.notify_all();
    for (std::thread& helper : helpers) helper.join();
    helpers.clear();
  }
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
  MT_REQUIRE(threads >= 1, "at least the calling thread");
  shared_->helpers.reserve(static_cast<std::size_t>(threads));
  try {
    for (int i = 1; i < threads; ++i) shared_->helpers.emplace_back([shared = shared_.get(), i] { shared->help(i); });
  } catch (const std::system_error& error) {
    const std::string had = std::to_string(this->threads());
    shared_->end();
    throw_error({"the machine provides only " + had + " of " + std::to_string(threads) + " threads: " + error.what(), "",
                 "ask for fewer"});
  }
}

Pool::~Pool() { shared_->end(); }

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
