#include <cli/page_server.hpp>

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>
#include <utility>

namespace momentree::cli {

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
    polled.assign(1, {listener_.socket.get(), POLLIN, 0});
    for (const Connection& connection : connections_) {
      const bool sending = connection.stage == Stage::sending;
      polled.push_back({connection.socket.get(), static_cast<short>(sending ? POLLOUT : POLLIN), 0});
    }
    if (::poll(polled.data(), polled.size(), patience) < 0 && errno != EINTR) std::this_thread::sleep_for(milliseconds(patience));
    const Clock::time_point now = Clock::now();
    for (std::size_t i = 0; i < connections_.size(); ++i) {
      Connection& connection = connections_[i];
      connection.over = (polled[i + 1].revents != 0 && !go_on(connection)) || connection.deadline <= now;
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
    const std::size_t head = head_size(connection.head, before);
    if (head != std::string::npos || connection.head.size() > limits_.head) answer(connection, head);
  }
  return true;
}

void PageServer::answer(Connection& connection, std::size_t head) {
  Reply reply;
  if (head > limits_.head) {  // npos, too
    reply = refusal(site_, 431);
  } else {
    const std::optional<HttpRequest> request = parse_head(std::string_view(connection.head).substr(0, head));
    reply = request ? reply_to(*request, site_) : refusal(site_, 400);
  }
  connection.head = std::move(reply.head);
  connection.body = reply.body;
  connection.stage = Stage::sending;
  connection.deadline = Clock::now() + limits_.stall;
}

bool PageServer::send(Connection& connection) {
  const std::size_t size = connection.head.size() + connection.body.size();
  while (connection.sent < size) {
    const bool in_head = connection.sent < connection.head.size();
    const std::string_view rest = in_head ? std::string_view(connection.head).substr(connection.sent)
                                          : connection.body.substr(connection.sent - connection.head.size());
    const auto count = ::send(connection.socket.get(), rest.data(), rest.size(), quietly);
    if (count < 0) return try_later();
    connection.sent += static_cast<std::size_t>(count);
    connection.deadline = Clock::now() + limits_.stall;
  }
  ::shutdown(connection.socket.get(), SHUT_WR);
  connection.stage = Stage::leaving;
  connection.deadline = Clock::now() + limits_.goodbye;
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

}  // namespace momentree::cli
