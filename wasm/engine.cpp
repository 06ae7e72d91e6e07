// The engine as a module for browsers: sessions, to which host.mjs sends messages (momentree/pages/README.md).
//
// Unexpected errors are passed to the imported function momentree.fail(text, length), which must not return: it throws, and the
// instance must not be used again.
#include <chrono>
#include <cstdlib>

#include <momentree/pages/page_session.hpp>

using namespace momentree;
using io::PageSession;

#define EXPORT(name) extern "C" __attribute__((export_name(#name)))

/// A message of the session that is called: JSON, and the bytes of the frame in it. They are valid during the call.
extern "C" __attribute__((import_module("momentree"), import_name("post"))) void momentree_post(const char* text, size_t length,
                                                                                                const void* frame, size_t bytes);

namespace {

io::PageHost host() {
  return {[](const std::string& text, std::span<const unsigned char> frame) {
            momentree_post(text.data(), text.size(), frame.data(), frame.size());
          },
          [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }};
}

}  // namespace

/// Memory for texts that are passed in.
EXPORT(mt_allocate) void* mt_allocate(size_t bytes) { return std::malloc(bytes); }
EXPORT(mt_release) void mt_release(void* memory) { std::free(memory); }

EXPORT(mt_open) PageSession* mt_open() { return new PageSession(host()); }
/// A session of an independent run from where the session is.
EXPORT(mt_branch) PageSession* mt_branch(PageSession* session) { return new PageSession(host(), session->run().branch()); }
EXPORT(mt_close) void mt_close(PageSession* session) { delete session; }

/// A message to a session that plays; what has changed is posted.
EXPORT(mt_send) void mt_send(PageSession* session, const char* text, size_t length) {
  io::Message message({text, length});
  session->obey(message);
}
EXPORT(mt_tick) void mt_tick(PageSession* session, double seconds) { session->tick(seconds); }

/// A message to the session's run, which only posts an answer.
EXPORT(mt_ask) void mt_ask(PageSession* session, const char* text, size_t length) {
  io::Message message({text, length});
  session->run().obey(message);
}
/// Numbers of the session's run, by PageRun::Numbers: where they are, and how many. Valid until the next call.
EXPORT(mt_numbers) const void* mt_numbers(PageSession* session, int which) {
  const std::vector<double>& numbers = session->run().numbers(static_cast<io::PageRun::Numbers>(which));
  static struct {
    const double* at;
    size_t count;
  } found;
  found = {numbers.data(), numbers.size()};
  return &found;
}
