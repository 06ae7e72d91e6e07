#pragma once
// Answers requests for one page in one thread, many connections at a time. Nobody who connects can keep others from the page,
// or make it take memory: heads are bounded, each stage has a deadline, and when all places are taken an old connection gives
// way to a new one.
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
  std::size_t head = 16 * 1024;             ///< bytes
  std::chrono::milliseconds request{5000};  ///< from the connection on until its head is there
  std::chrono::milliseconds stall{15000};   ///< in which the client takes nothing of the reply
  std::chrono::milliseconds goodbye{1000};  ///< until the client has closed, too
};

class PageServer {
 public:
  /// `listener`: of listen_on().
  PageServer(Listener listener, Site site, const Limits& limits = {});
  /// Until `stop` is true, which is asked every 50 ms.
  void run(const std::function<bool()>& stop);
  /// How many connections there are.
  std::size_t connections() const { return connections_.size(); }

 private:
  using Clock = std::chrono::steady_clock;
  /// What a connection does next, in this order.
  enum class Stage { reading, sending, leaving };
  struct Connection {
    Socket socket;
    Stage stage = Stage::reading;
    Clock::time_point deadline;
    std::string head{};  ///< of the request while it is read, then of the reply
    std::string_view body{};
    std::size_t sent = 0;
    bool over = false;
  };

  void accept_all();
  bool make_room();
  /// False: it is over.
  bool go_on(Connection& connection);
  bool read(Connection& connection);
  void answer(Connection& connection, std::size_t head);
  bool send(Connection& connection);
  bool leave(Connection& connection);

  Listener listener_;
  Site site_;
  Limits limits_;
  std::vector<Connection> connections_;  ///< the oldest first
};

}  // namespace momentree::cli
