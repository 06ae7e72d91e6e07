#pragma once
// Serves one page in a single thread over many connections. No client can block others from the page or exhaust memory: heads
// are bounded, each stage has a deadline, and when all connections are in use, an old one is dropped for a new one. A live page
// keeps one connection, on which it receives the messages of a feed.
#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/live/feed.hpp>
#include <momentree/live/http.hpp>
#include <momentree/live/listener.hpp>

namespace momentree::live {

struct Limits {
  std::size_t connections = 128;
  std::size_t streams = 16;                 ///< of `connections`, those of live pages
  std::size_t head = 16 * 1024;             ///< largest request head (bytes)
  std::chrono::milliseconds request{5000};  ///< from connecting until the head is complete
  std::chrono::milliseconds stall{15000};   ///< while the client accepts none of the reply
  std::chrono::milliseconds goodbye{1000};  ///< until the client has closed the connection, too
  std::chrono::milliseconds beat{10000};    ///< without a message to a live page until it gets an empty one
};

class PageServer {
 public:
  /// `listener`: from listen_on().
  PageServer(Listener listener, Site site, const Limits& limits = {});
  /// Serves until `stop` returns true; it is called every 50 ms.
  void run(const std::function<bool()>& stop);
  /// The number of open connections.
  std::size_t connections() const { return connections_.size(); }

 private:
  using Clock = std::chrono::steady_clock;
  /// The stages of a connection, in order.
  enum class Stage { reading, sending, leaving, streaming };
  struct Connection {
    Socket socket;
    Stage stage = Stage::reading;
    Clock::time_point deadline;
    std::string head{};  ///< the request while it is read, then the reply's head or, of a stream, what is to be sent
    std::string_view body{};
    std::size_t sent = 0;
    bool over = false, streams = false;
    std::size_t request_head = std::string::npos;  ///< size of the request's head, once it is complete
    Feed::Reader reader{};
  };

  void accept_all();
  bool make_room();
  /// Returns false if the connection is finished.
  bool go_on(Connection& connection);
  bool read(Connection& connection);
  /// Returns false if the body of the request is not complete.
  bool answer(Connection& connection);
  bool send_rest(Connection& connection, bool& all);
  bool stream(Connection& connection);
  bool send(Connection& connection);
  bool leave(Connection& connection);

  Listener listener_;
  Site site_;
  Limits limits_;
  std::vector<Connection> connections_;  ///< oldest first
};

}  // namespace momentree::live
