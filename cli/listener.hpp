#pragma once
// A TCP socket that listens on 127.0.0.1.
#include <utility>

namespace momentree::cli {

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

/// Listens on `port`, which nobody else listens on then; 0: any that is free. The socket does not block, and no child process
/// inherits it. Throws Error where the port can't be had: of a port in use it names another that is free.
Listener listen_on(int port);

/// Non-blocking and closed on exec.
void prepare(const Socket& socket);

}  // namespace momentree::cli
