#include <momentree/live/page_server.hpp>

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>
#include <utility>

namespace momentree::live {

using std::chrono::milliseconds;

namespace {

#ifdef MSG_NOSIGNAL
constexpr int quietly = MSG_NOSIGNAL;
#else
constexpr int quietly = 0;  // SO_NOSIGPIPE of the socket
#endif

constexpr int patience = 50;  // ms

bool try_later() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

PageServer::PageServer(Listener listener, Site site, const Limits& limits)
    : listener_(std::move(listener)), site_(std::move(site)), limits_(limits) {}

void PageServer::run(const std::function<bool()>& stop) {
  std::vector<pollfd> polled;
  while (!stop()) {
    polled.assign(2, {listener_.socket.get(), POLLIN, 0});
    polled[1].fd = site_.feed != nullptr ? site_.feed->signal() : -1;  // poll() ignores -1
    for (Connection& connection : connections_) {
      const bool waits = connection.stage == Stage::streaming && connection.sent == connection.head.size();
      const bool sends = connection.stage == Stage::sending || (connection.stage == Stage::streaming && !waits);
      polled.push_back({connection.socket.get(), static_cast<short>(sends ? POLLOUT : POLLIN), 0});
    }
    if (::poll(polled.data(), polled.size(), patience) < 0 && errno != EINTR) std::this_thread::sleep_for(milliseconds(patience));
    if (site_.feed != nullptr) site_.feed->quieten();
    const Clock::time_point now = Clock::now();
    for (std::size_t i = 0; i < connections_.size(); ++i) {
      Connection& connection = connections_[i];
      const bool ready = polled[i + 2].revents != 0 || connection.stage == Stage::streaming;
      connection.over = (ready && !go_on(connection)) || connection.deadline <= now;
    }
    std::erase_if(connections_, [](const Connection& connection) { return connection.over; });
    if (polled[0].revents != 0) accept_all();
  }
  connections_.clear();
}

void PageServer::accept_all() {
  // At most as many at once as there are connections, so that new ones are read before they may be dropped.
  for (std::size_t count = 0; count < limits_.connections; ++count) {
    Socket socket(::accept(listener_.socket.get(), nullptr, nullptr));
    if (!socket) {
      if (errno == EINTR || errno == ECONNABORTED) continue;
      if (errno == EMFILE || errno == ENFILE) {
        if (make_room()) continue;
        std::this_thread::sleep_for(milliseconds(patience));  // until other programs close some
      }
      return;
    }
    prepare(socket);
#ifdef SO_NOSIGPIPE
    const int yes = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_NOSIGPIPE, &yes, sizeof yes);
#endif
    if (connections_.size() >= limits_.connections) make_room();
    connections_.push_back({std::move(socket), Stage::reading, Clock::now() + limits_.request});
    if (!go_on(connections_.back())) connections_.pop_back();
  }
}

/// Drops the oldest connection: of those that only have to close, or else of the larger group among those that read and those
/// that send.
bool PageServer::make_room() {
  const auto oldest = [this](Stage stage) { return std::ranges::find(connections_, stage, &Connection::stage); };
  auto one = oldest(Stage::leaving);
  if (one == connections_.end()) {
    const auto reading = static_cast<std::size_t>(std::ranges::count(connections_, Stage::reading, &Connection::stage));
    one = oldest(2 * reading >= connections_.size() ? Stage::reading : Stage::sending);
  }
  if (one == connections_.end()) return false;
  connections_.erase(one);
  return true;
}

bool PageServer::go_on(Connection& connection) {
  if (connection.stage == Stage::reading && !read(connection)) return false;
  if (connection.stage == Stage::sending && !send(connection)) return false;
  if (connection.stage == Stage::streaming && !stream(connection)) return false;
  return connection.stage != Stage::leaving || leave(connection);
}

bool PageServer::read(Connection& connection) {
  std::array<char, 4096> bytes;
  while (connection.stage == Stage::reading) {
    const auto count = ::recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
    if (count < 0) return try_later();
    if (count == 0) return false;
    const std::size_t before = connection.head.size();
    connection.head.append(bytes.data(), static_cast<std::size_t>(count));
    if (connection.request_head == std::string::npos) connection.request_head = head_size(connection.head, before);
    if (connection.request_head != std::string::npos || connection.head.size() > limits_.head) answer(connection);
  }
  return true;
}

bool PageServer::answer(Connection& connection) {
  Reply reply;
  if (connection.request_head > limits_.head) {  // npos, too
    reply = refusal(site_, 431);
  } else {
    const std::string_view received = connection.head;
    const std::optional<HttpRequest> request = parse_head(received.substr(0, connection.request_head));
    const std::string_view rest = received.substr(connection.request_head);
    const std::size_t body = request && takes_body(*request, site_) ? request->body_size : 0;
    if (rest.size() < body) return false;
    reply = request ? reply_to(*request, site_, rest.substr(0, body)) : refusal(site_, 400);
  }
  if (reply.streams && static_cast<std::size_t>(std::ranges::count(connections_, true, &Connection::streams)) >= limits_.streams)
    reply = refusal(site_, 503);
  connection.head = std::move(reply.head);
  connection.body = reply.body;
  connection.streams = reply.streams;
  connection.stage = Stage::sending;
  connection.deadline = Clock::now() + limits_.stall;
  return true;
}

/// Sends what the client accepts; `all`: nothing is left.
bool PageServer::send_rest(Connection& connection, bool& all) {
  const std::size_t size = connection.head.size() + connection.body.size();
  all = false;
  while (connection.sent < size) {
    const bool in_head = connection.sent < connection.head.size();
    const std::string_view rest = in_head ? std::string_view(connection.head).substr(connection.sent)
                                          : connection.body.substr(connection.sent - connection.head.size());
    const auto count = ::send(connection.socket.get(), rest.data(), rest.size(), quietly);
    if (count < 0) return try_later();
    connection.sent += static_cast<std::size_t>(count);
    connection.deadline = Clock::now() + limits_.stall;
  }
  all = true;
  return true;
}

bool PageServer::send(Connection& connection) {
  bool all = false;
  if (!send_rest(connection, all)) return false;
  if (!all) return true;
  if (connection.streams) {
    connection.stage = Stage::streaming;
    connection.deadline = Clock::now() + limits_.beat;
    return true;
  }
  ::shutdown(connection.socket.get(), SHUT_WR);
  connection.stage = Stage::leaving;
  connection.deadline = Clock::now() + limits_.goodbye;
  return true;
}

/// Sends the messages that the page lacks. A page that does not accept them gets only the newest frame once it does.
bool PageServer::stream(Connection& connection) {
  if (!leave(connection)) return false;  // the page has closed the connection
  const Clock::time_point now = Clock::now();
  for (bool all = true; all;) {
    if (connection.sent == connection.head.size()) {
      connection.head.clear(), connection.sent = 0;
      site_.feed->append_new(connection.reader, connection.head);
      const bool beats = connection.head.empty() && connection.deadline <= now + milliseconds(patience);
      if (beats) connection.head = ":\n\n";
      if (connection.head.empty()) return true;
      connection.deadline = now + limits_.stall;
    }
    if (!send_rest(connection, all)) return false;
    if (all) connection.deadline = now + limits_.beat;
  }
  return true;
}

/// Discards further input for a moment: closing a connection with unread bytes would discard the reply.
bool PageServer::leave(Connection& connection) {
  std::array<char, 4096> bytes;
  for (int count = 0; count < 16; ++count) {
    const auto received = ::recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
    if (received < 0) return try_later();
    if (received == 0) return false;
  }
  return true;
}

}  // namespace momentree::live
