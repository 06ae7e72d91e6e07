#include <momentree/sweep/machines/worker.hpp>

#include <unistd.h>

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::sweep {

using namespace std::chrono_literals;

namespace {

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "unknown host";
}

}  // namespace

Worker::Worker(Communicator& communicator, const RunChunk& run, const DistributeOptions& options)
    : communicator_(communicator),
      run_(run),
      options_(options),
      no_memory_(encode(failure_note(std::make_exception_ptr(std::bad_alloc())))) {}

Worker::~Worker() { join_threads(); }

void Worker::work() {
  communicator_.send(
      0, encode({MessageKind::hello, {}, static_cast<double>(options_.threads), {options_.version, options_.work, host_name()}}));
  try {
    start_threads();
  } catch (...) {
    fail(std::current_exception());
  }
  serve();
  if (options_.cancel != nullptr) options_.cancel->store(true);
  join_threads();
  communicator_.send(0, encode({MessageKind::ended}));
  for (;;) {
    const std::optional<Communicator::Message> message = communicator_.receive(1s);
    if (message && decode(message->bytes).kind == MessageKind::leave) break;
  }
  communicator_.finish();
}

void Worker::start_threads() {
  threads_.reserve(static_cast<std::size_t>(options_.threads));
  try {
    while (std::ssize(threads_) < options_.threads) threads_.emplace_back([this] { compute(); });
  } catch (const std::system_error& error) {
    throw_error({"cannot start " + std::to_string(options_.threads) + " threads: " + error.code().message(), "", "use fewer"});
  }
}

void Worker::join_threads() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void Worker::fail(const std::exception_ptr& failure) noexcept {
  try {
    std::string bytes;
    try {
      bytes = encode(failure_note(failure));
    } catch (const std::bad_alloc&) {
    }
    communicator_.send(0, bytes.empty() ? no_memory_ : bytes);
  } catch (...) {  // rank 0 cannot be told
    communicator_.abort(1);
  }
}

void Worker::compute() {
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return over_ || !waiting_.empty(); });
    if (over_) return;
    const Chunk chunk = waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    try {
      const auto start = std::chrono::steady_clock::now();
      std::string encoded = run_(chunk);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      lock.lock();
      if (over_ || interrupted() || encoded.empty()) return;
      lock.unlock();
      communicator_.send(0, encode({MessageKind::result, chunk, took.count(), {std::move(encoded)}}));
    } catch (...) {
      const std::lock_guard again(mutex_);
      if (!over_ && !interrupted()) fail(std::current_exception());
      return;
    }
  }
}

void Worker::serve() {
  for (bool told = false;;) {
    if (options_.progress) options_.progress();
    if (interrupted() && !std::exchange(told, true)) communicator_.send(0, encode({MessageKind::interrupted}));
    const std::optional<Communicator::Message> message = communicator_.receive(100ms);
    if (!message) continue;
    const Note note = decode(message->bytes);
    if (note.kind == MessageKind::stop) return;
    const std::lock_guard lock(mutex_);
    if (note.kind == MessageKind::work) waiting_.push_back(note.chunk);
    if (note.kind == MessageKind::drop) std::erase(waiting_, note.chunk);
    changed_.notify_one();
  }
}

}  // namespace momentree::sweep
