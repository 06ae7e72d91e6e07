#include <cli/interrupt.hpp>

#include <csignal>

namespace momentree::cli {

namespace {
// The only kind of variable that a signal handler may write.
volatile std::sig_atomic_t signalled = 0;
int guards = 0;  // at this time; only the outermost one changes anything

extern "C" void note_signal(int signal) {
  signalled = 1;
  std::signal(signal, SIG_DFL);
}
}  // namespace

InterruptGuard::InterruptGuard() {
  if (guards++ > 0) return;
  signalled = 0;
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
}

InterruptGuard::~InterruptGuard() {
  if (--guards > 0) return;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::interrupted() { return signalled != 0; }

}  // namespace momentree::cli
