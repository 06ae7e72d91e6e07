#pragma once
// Messages between a running program and the pages that show it. The program's thread and the server's may use a feed at the same
// time.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace momentree::live {

class Feed {
 public:
  /// Throws Error if the system has no pipe left.
  Feed();
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  // For the program. Messages are JSON on one line.

  /// What pages that open from now on get first instead of the messages posted so far; if `all`, open pages get it now.
  void greet(std::vector<std::string> messages, bool all);
  /// A message for every page, after those posted before.
  void post(std::string message);
  /// Replaces the last frame: a page that is slow gets only the newest one.
  void show(std::string frame);
  bool has_texts() const;
  /// The texts that pages have sent since the last call.
  std::vector<std::string> take();
  /// Waits until a page has sent a text, at most for this time.
  void wait(std::chrono::nanoseconds most);
  /// The number of times that a page has connected.
  int pages() const;

  // For the server.

  /// What a page has received.
  struct Reader {
    std::uint64_t greeting = 0, next = 0, frame = 0;
  };
  /// Appends the messages that the page lacks as server-sent events.
  void append_new(Reader& reader, std::string& text);
  void receive(std::string_view text);
  /// A descriptor that is readable when there are new messages, until quieten().
  int signal() const { return pipe_[0]; }
  void quieten();

 private:
  void wake();

  mutable std::mutex mutex_;
  std::condition_variable received_;
  std::vector<std::string> greeting_;
  std::uint64_t greeted_ = 1;       ///< number of the first message that it does not contain
  std::deque<std::string> posted_;  ///< the last messages
  std::uint64_t first_ = 1;         ///< number of the first of them
  std::size_t bytes_ = 0;           ///< of all of them
  std::uint64_t greetings_ = 1;     ///< pages with a smaller number get the greeting
  std::string frame_;
  std::uint64_t frames_ = 0;
  std::vector<std::string> taken_;
  int pages_ = 0;
  bool awake_ = false;
  int pipe_[2] = {-1, -1};
};

}  // namespace momentree::live
