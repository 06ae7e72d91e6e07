#include <momentree/live/feed.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::live {

namespace {

/// Pages that lack more messages than these get the greeting again.
constexpr std::size_t most_posted = 4096, most_bytes = 4 << 20;
/// Texts that a program does not take are dropped beyond this number.
constexpr std::size_t most_taken = 4096;

void append_event(std::string& text, std::string_view message) {
  text += "data: ";
  for (const char c : message) text += c == '\n' || c == '\r' ? ' ' : c;  // blanks between the values of JSON
  text += "\n\n";
}

}  // namespace

Feed::Feed() {
  if (::pipe(pipe_) != 0) throw_error({std::string("cannot open a pipe: ") + std::strerror(errno), "", ""});
  for (const int end : pipe_) {
    ::fcntl(end, F_SETFL, ::fcntl(end, F_GETFL) | O_NONBLOCK);
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
}

Feed::~Feed() {
  for (const int end : pipe_) ::close(end);
}

void Feed::wake() {
  if (std::exchange(awake_, true)) return;
  const char byte = 0;
  [[maybe_unused]] const auto written = ::write(pipe_[1], &byte, 1);
}

void Feed::quieten() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(awake_, false)) return;
  char bytes[16];
  while (::read(pipe_[0], bytes, sizeof bytes) > 0) {
  }
}

void Feed::greet(std::vector<std::string> messages, bool all) {
  const std::lock_guard lock(mutex_);
  greeting_ = std::move(messages);
  greeted_ = first_ + posted_.size();
  if (all) ++greetings_, frame_.clear(), wake();
}

void Feed::post(std::string message) {
  const std::lock_guard lock(mutex_);
  bytes_ += message.size();
  posted_.push_back(std::move(message));
  while (posted_.size() > 1 && (posted_.size() > most_posted || bytes_ > most_bytes)) {
    bytes_ -= posted_.front().size();
    posted_.pop_front();
    ++first_;
  }
  wake();
}

void Feed::show(std::string frame) {
  const std::lock_guard lock(mutex_);
  frame_ = std::move(frame);
  ++frames_;
  wake();
}

bool Feed::has_texts() const {
  const std::lock_guard lock(mutex_);
  return !taken_.empty();
}

std::vector<std::string> Feed::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(taken_, {});
}

void Feed::wait(std::chrono::nanoseconds most) {
  std::unique_lock lock(mutex_);
  received_.wait_for(lock, most, [this] { return !taken_.empty(); });
}

int Feed::pages() const {
  const std::lock_guard lock(mutex_);
  return pages_;
}

void Feed::append_new(Reader& reader, std::string& text) {
  const std::lock_guard lock(mutex_);
  if (greeting_.empty()) return;
  const std::uint64_t end = first_ + posted_.size();
  if (reader.greeting < greetings_ || reader.next < first_) {
    if (reader.greeting == 0) ++pages_;
    for (const std::string& message : greeting_) append_event(text, message);
    reader.greeting = greetings_;
    reader.next = std::max(greeted_, first_);
  }
  for (; reader.next < end; ++reader.next) append_event(text, posted_[reader.next - first_]);
  if (reader.frame != frames_ && !frame_.empty()) append_event(text, frame_);
  reader.frame = frames_;
}

void Feed::receive(std::string_view text) {
  {
    const std::lock_guard lock(mutex_);
    if (taken_.size() < most_taken) taken_.emplace_back(text);
  }
  received_.notify_all();
}

}  // namespace momentree::live
