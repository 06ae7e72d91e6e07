#include <momentree/sweep/machines/distributor.hpp>

#include <algorithm>
#include <system_error>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::sweep {

using namespace std::chrono_literals;

namespace {
constexpr auto turn = 50ms;  // of the serving loop without messages, and of an idle thread
}

Distributor::Distributor(Communicator* communicator, WorkSource& source, const RunChunk& run, const DistributeOptions& options)
    : communicator_(communicator),
      source_(source),
      run_(run),
      options_(options),
      ranks_(communicator == nullptr ? 1 : communicator->size()),
      ledger_(ranks_),
      hosts_(static_cast<std::size_t>(ranks_)) {}

Distributor::~Distributor() { join_threads(); }

int Distributor::distribute() {
  try {
    start_threads();
    serve();
  } catch (...) {
    fail(std::current_exception());
  }
  const Ending ending = end();
  const Clock::time_point told = Clock::now();
  if (communicator_ != nullptr)
    for (int rank = 1; rank < ranks_; ++rank) communicator_->send(rank, encode({MessageKind::stop}));
  const int code = options_.conclude(ending, ending == Ending::failed ? failure_ : nullptr);
  join_threads();
  return take_leave(code, told);
}

void Distributor::start_threads() {
  ledger_.join(0, options_.threads);
  threads_.reserve(static_cast<std::size_t>(options_.threads));
  try {
    while (std::ssize(threads_) < options_.threads) threads_.emplace_back([this] { compute(); });
  } catch (const std::system_error& error) {
    throw_error({"cannot start " + std::to_string(options_.threads) + " threads: " + error.code().message(), "", "use fewer"});
  }
}

void Distributor::join_threads() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

// A thread of this rank.
void Distributor::compute() {
  std::unique_lock lock(mutex_);
  while (!over_) {
    std::optional<Chunk> chunk;
    try {
      chunk = chunk_for(0, options_.threads, Clock::now());
      if (!chunk) {
        changed_.wait_for(lock, turn);
        continue;
      }
      lock.unlock();
      const Clock::time_point start = Clock::now();
      std::string encoded = run_(*chunk);
      const std::chrono::duration<double> took = Clock::now() - start;
      if (!encoded.empty()) take_result(0, {MessageKind::result, *chunk, took.count(), {std::move(encoded)}});
    } catch (...) {
      if (lock.owns_lock()) lock.unlock();
      if (!interrupted()) fail(std::current_exception());
    }
    if (!lock.owns_lock()) lock.lock();
    if (interrupted()) changed_.wait_for(lock, turn);  // until serve() has noticed it
  }
}

void Distributor::fail(std::exception_ptr failure) {
  const std::lock_guard lock(mutex_);
  if (!over_ && !failure_) failure_ = std::move(failure);
  changed_.notify_all();
}

// Requires the mutex. A rank that has `wanted` chunks gets none.
std::optional<Chunk> Distributor::chunk_for(int rank, int wanted, Clock::time_point now) {
  if (ledger_.held(rank) >= wanted) return std::nullopt;
  std::optional<Chunk> chunk = source_.next();
  if (!chunk && ledger_.held(rank) < ledger_.threads(rank)) {
    const std::optional<Ledger::Again> again = ledger_.overdue(rank, now);
    if (!again) return std::nullopt;
    if (again->from && *again->from != 0) communicator_->send(*again->from, encode({MessageKind::drop, again->chunk}));
    source_.give_again(again->chunk);
    chunk = source_.next();
  }
  if (chunk) ledger_.give(rank, *chunk, now);
  return chunk;
}

void Distributor::take_result(int rank, Note note) {
  std::vector<int> others;
  {
    const std::lock_guard lock(mutex_);
    if (over_ || (rank == 0 && interrupted())) return;
    others = ledger_.finish(rank, note.chunk, note.number, Clock::now());
    ++storing_;
  }
  for (const int other : others)
    if (other != 0) communicator_->send(other, encode({MessageKind::drop, note.chunk}));
  std::exception_ptr failure;
  try {
    source_.finished(note.chunk, std::move(note.texts[0]));
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  --storing_;
  if (failure && !failure_) failure_ = failure;
  complete_ = source_.complete();
  changed_.notify_all();
}

// Gives each rank chunks for its threads and as many again.
void Distributor::fill() {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  for (bool any = true; any && !failure_;) {
    any = false;
    for (int rank = 1; rank < ranks_; ++rank) {
      const std::optional<Chunk> chunk = chunk_for(rank, 2 * ledger_.threads(rank), now);
      if (chunk) communicator_->send(rank, encode({MessageKind::work, *chunk}));
      any = any || chunk.has_value();
    }
  }
}

void Distributor::check_hello(int rank, const Note& note) {
  const std::string name = "rank " + std::to_string(rank) + " (" + note.texts[2] + ")";
  if (note.texts[0] != options_.version)
    throw_error({name + " runs version " + note.texts[0] + " of momentree, and rank 0 version " + options_.version, "",
                 "install the same version on all machines"});
  if (note.texts[1] != options_.work)
    throw_error({name + " has read other files than rank 0", "",
                 "all ranks must see the same scenario and model files, and have the same arguments"});
  hosts_[static_cast<std::size_t>(rank)] = note.texts[2];
  const std::lock_guard lock(mutex_);
  ledger_.join(rank, std::max(1, static_cast<int>(note.number)));
}

void Distributor::hear(const Communicator::Message& message) {
  Note note = decode(message.bytes);
  switch (note.kind) {
    case MessageKind::hello: return check_hello(message.from, note);
    case MessageKind::result: return take_result(message.from, std::move(note));
    case MessageKind::failure: return fail(failure_of(note, message.from));
    case MessageKind::interrupted: rank_interrupted_ = true; return;
    default: return;  // `ended` comes after `stop`
  }
}

void Distributor::serve() {
  const auto going_on = [this] {
    const std::lock_guard lock(mutex_);
    return !complete_ && !failure_ && !rank_interrupted_ && !interrupted();
  };
  {
    const bool complete = source_.complete();  // all of it was done before
    const std::lock_guard lock(mutex_);
    complete_ = complete_ || complete;
  }
  Clock::time_point shown = Clock::now() - turn;
  while (going_on()) {
    if (communicator_ != nullptr) {
      fill();
      for (auto message = communicator_->receive(turn); message && going_on(); message = communicator_->receive(0ms)) {
        hear(*message);
        if (Clock::now() - shown >= turn) break;
        fill();
      }
    } else {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, turn);
    }
    if (Clock::now() - shown < turn) continue;
    shown = Clock::now();
    if (options_.progress) options_.progress();
  }
  if (options_.progress) options_.progress();
}

// After this no result reaches the source.
Ending Distributor::end() {
  std::unique_lock lock(mutex_);
  over_ = true;
  if (options_.cancel != nullptr) options_.cancel->store(true);
  changed_.notify_all();
  changed_.wait(lock, [this] { return storing_ == 0; });
  return failure_ ? Ending::failed : complete_ ? Ending::complete : Ending::interrupted;
}

// Messages that were sent before the end are read and ignored.
int Distributor::take_leave(int code, Clock::time_point told) {
  if (communicator_ == nullptr) return code;
  // Answers that came while the results were published are still to be received.
  const Clock::time_point end = std::max(told + options_.grace, Clock::now() + std::min<Clock::duration>(options_.grace, 1s));
  while (std::ssize(ended_) < ranks_ - 1) {
    const std::optional<Communicator::Message> message = communicator_->receive(turn);
    if (message) {
      try {
        if (decode(message->bytes).kind == MessageKind::ended) ended_.insert(message->from);
      } catch (const Error&) {  // of another program: it will not answer
      }
      continue;
    }
    if (Clock::now() < end) continue;
    std::string silent;
    for (int rank = 1; rank < ranks_; ++rank) {
      if (ended_.contains(rank)) continue;
      const std::string& host = hosts_[static_cast<std::size_t>(rank)];
      silent += (silent.empty() ? "rank " : ", rank ") + std::to_string(rank) + (host.empty() ? "" : " (" + host + ")");
    }
    if (options_.warn) options_.warn(silent + " did not answer and was ended");
    communicator_->abort(code);
  }
  for (int rank = 1; rank < ranks_; ++rank) communicator_->send(rank, encode({MessageKind::leave}));
  communicator_->finish();
  return code;
}

}  // namespace momentree::sweep
