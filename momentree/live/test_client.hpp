#pragma once
// A client of a server on this machine that sends and receives bytes as told.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <momentree/live/listener.hpp>

namespace momentree::live::test {

class Client {
 public:
  explicit Client(int port, int buffer = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (buffer != 0) ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    if (::connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("no server");
  }
  bool send(const std::string& text) const {
    return ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  /// Everything received until the server closes.
  std::string receive() const {
    std::string all;
    char bytes[4096];
    for (ssize_t count; (count = ::recv(socket_.get(), bytes, sizeof bytes, 0)) > 0;)
      all.append(bytes, static_cast<std::size_t>(count));
    return all;
  }
  /// What arrives until it contains `part`, or until the server closes; the rest of what arrived with it stays for the next call.
  std::string receive_to(const std::string& part) {
    char bytes[4096];
    for (;;) {
      if (const std::size_t at = left_.find(part); at != std::string::npos) {
        std::string all = left_.substr(0, at + part.size());
        left_.erase(0, at + part.size());
        return all;
      }
      const ssize_t count = ::recv(socket_.get(), bytes, sizeof bytes, 0);
      if (count <= 0) return std::exchange(left_, {});
      left_.append(bytes, static_cast<std::size_t>(count));
    }
  }
  int get() const { return socket_.get(); }

 private:
  std::string left_;
  Socket socket_;
};

template <class Condition>
void wait_until(const Condition& condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(5));  // ctest ends tests that take too long
}

}  // namespace momentree::live::test
