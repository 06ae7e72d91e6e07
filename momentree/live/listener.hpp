#pragma once
// A TCP socket that listens on 127.0.0.1.
#include <utility>

namespace momentree::live {

/// Owns a file descriptor; −1: none.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket();
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

struct Listener {
  Socket socket;
  int port;
};

/// Listens exclusively on `port`; 0: any free port. The socket is non-blocking and not inherited by child processes. Throws
/// Error if the port is not available; if it is in use, the message names a free one.
Listener listen_on(int port);

/// Makes the socket non-blocking and closed on exec.
void prepare(const Socket& socket);

}  // namespace momentree::live
