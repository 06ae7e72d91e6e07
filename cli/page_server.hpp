#pragma once
// Serves one page in a single thread over many connections. No client can block others from the page or exhaust memory: heads
// are bounded, each stage has a deadline, and when all connections are in use, an old one is dropped for a new one.
#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <cli/http.hpp>
#include <cli/listener.hpp>

namespace momentree::cli {

struct Limits {
  std::size_t connections = 128;
  std::size_t head = 16 * 1024;             ///< largest request head (bytes)
  std::chrono::milliseconds request{5000};  ///< from connecting until the head is complete
  std::chrono::milliseconds stall{15000};   ///< while the client accepts none of the reply
  std::chrono::milliseconds goodbye{1000};  ///< until the client has closed the connection, too
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
  enum class Stage { reading, sending, leaving };
  struct Connection {
    Socket socket;
    Stage stage = Stage::reading;
    Clock::time_point deadline;
    std::string head{};  ///< the request head while it is read, then that of the reply
    std::string_view body{};
    std::size_t sent = 0;
    bool over = false;
  };

  void accept_all();
  bool make_room();
  /// Returns false if the connection is finished.
  bool go_on(Connection& connection);
  bool read(Connection& connection);
  void answer(Connection& connection, std::size_t head);
  bool send(Connection& connection);
  bool leave(Connection& connection);

  Listener listener_;
  Site site_;
  Limits limits_;
  std::vector<Connection> connections_;  ///< oldest first
};

}  // namespace momentree::cli
