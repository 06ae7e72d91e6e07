#include <momentree/live/listener.hpp>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

#include <momentree/base/error.hpp>

namespace momentree::live {

namespace {

constexpr int backlog = 128;
constexpr int tries = 20;

/// nullopt if the port is not available; `reason` is the errno.
std::optional<Listener> try_port(int port, int& reason) {
  Socket socket(::socket(AF_INET, SOCK_STREAM, 0));
  reason = errno;
  if (!socket) return std::nullopt;
  prepare(socket);
  // Only allows a port to be reused right after its last server ended (TIME_WAIT): two listening sockets never share it, which
  // SO_REUSEPORT would allow.
  const int yes = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  if (::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 || ::listen(socket.get(), backlog) != 0 ||
      ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    reason = errno;
    return std::nullopt;
  }
  return Listener{std::move(socket), ntohs(address.sin_port)};
}

/// The next free port after one that is in use, or any free one; 0 if no port is free.
int free_port_after(int port) {
  int reason = 0;
  for (int next = port + 1; next <= port + tries && next <= 65535; ++next)
    if (try_port(next, reason)) return next;
  const std::optional<Listener> any = try_port(0, reason);
  return any ? any->port : 0;
}

}  // namespace

Socket::~Socket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void prepare(const Socket& socket) {
  ::fcntl(socket.get(), F_SETFL, ::fcntl(socket.get(), F_GETFL) | O_NONBLOCK);
  ::fcntl(socket.get(), F_SETFD, FD_CLOEXEC);
}

Listener listen_on(int port) {
  int reason = 0;
  if (std::optional<Listener> listener = try_port(port, reason)) return std::move(*listener);
  const std::string name = "port " + std::to_string(port);
  if (port != 0 && reason == EADDRINUSE) {
    const int other = free_port_after(port);
    throw_error({name + " is in use", "--port",
                 other != 0 ? "port " + std::to_string(other) + " is free; without --port a free one is chosen"
                            : "no other port is free either"});
  }
  if (reason == EACCES)
    throw_error({name + " is reserved for the administrator", "--port", "choose one above 1023, or leave it out"});
  throw_error({"cannot listen on 127.0.0.1: " + std::string(std::strerror(reason)), port != 0 ? "--port" : "", ""});
}

}  // namespace momentree::live
