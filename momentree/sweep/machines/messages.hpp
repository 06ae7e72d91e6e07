#pragma once
// The messages of distribute(): encoding and decoding.
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep {

enum class MessageKind : std::uint8_t {
  // from a rank to rank 0
  hello,        ///< texts: version, work, host; number: threads
  result,       ///< chunk; number: duration (s); texts: the encoded result
  failure,      ///< texts: problem, where, hint; number: what kind of exception
  interrupted,  ///< `stop` was set on this rank
  ended,        ///< no thread of this rank computes any more
  // from rank 0
  work,   ///< chunk: compute it
  drop,   ///< chunk: no longer needed; ignored if it has been started
  stop,   ///< end the threads, then answer `ended`
  leave,  ///< all ranks have ended: finish
};

struct Note {
  MessageKind kind = MessageKind::stop;
  Chunk chunk = {};
  double number = 0;
  std::vector<std::string> texts = {};
};

std::string encode(const Note& note);
/// Throws Error for bytes that encode() did not make: the ranks run different programs.
Note decode(std::string_view bytes);

/// A `failure` for an exception, and the exception for it again.
Note failure_note(const std::exception_ptr& exception);
std::exception_ptr failure_of(const Note& note, int rank);

}  // namespace momentree::sweep
