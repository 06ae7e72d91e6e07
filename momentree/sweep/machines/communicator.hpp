#pragma once
// Messages between the processes (ranks) of a sweep.
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace momentree::sweep {

/// The ranks 0 … size() − 1 of one run, each a process. Messages between two ranks arrive complete and in order.
class Communicator {
 public:
  Communicator() = default;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;
  /// Does not end the ranks: a process that exits without finish() has failed, and the launcher ends the others.
  virtual ~Communicator();

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Sends a message of less than 2 GiB, without waiting until it is received. May be called from several threads.
  virtual void send(int to, std::string_view bytes) = 0;

  struct Message {
    int from;
    std::string bytes;
  };
  /// The next message from any rank; none if there is none in that time. Sleeps in between, so that a waiting rank takes almost
  /// no CPU time. For one thread.
  virtual std::optional<Message> receive(std::chrono::milliseconds timeout) = 0;

  /// Ends the communication, on all ranks: waits until every rank has called it.
  virtual void finish() = 0;
  /// Ends the processes of all ranks at once, with this exit code.
  [[noreturn]] virtual void abort(int code) = 0;
};

}  // namespace momentree::sweep
