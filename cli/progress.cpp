#include <cli/progress.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <cli/text.hpp>

namespace momentree::cli {

using namespace std::chrono_literals;

Progress::Progress(double start, double until, bool shown)
    : start_(start), until_(until), shown_(shown && until > start), began_(Clock::now()), next_(began_ + 200ms) {}

void Progress::at(double time) {
  if (!shown_) return;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + 100ms;
  const double done = std::clamp((time - start_) / (until_ - start_), 0.0, 1.0);
  const double spent = std::chrono::duration<double>(now - began_).count();
  constexpr int cells = 30;
  const int full = static_cast<int>(done * cells);
  std::string bar;
  for (int i = 0; i < cells; ++i) bar += i < full ? "█" : "░";
  std::string left;
  if (done > 0) {
    const long seconds = std::lround(std::min(spent * (1 - done) / done, 3.6e8));
    left = seconds < 3600 ? format(" · %ld:%02ld left", seconds / 60, seconds % 60)
                          : format(" · %ld:%02ld:%02ld left", seconds / 3600, seconds / 60 % 60, seconds % 60);
  }
  std::fprintf(stderr, "\r%s %3.0f %% · %.4g of %.4g s%s\x1b[K", bar.c_str(), 100 * done, time, until_, left.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::clear() {
  if (!drawn_) return;
  std::fputs("\r\x1b[K", stderr);
  drawn_ = false;
}

bool errors_on_terminal() {
  const char* term = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
}

}  // namespace momentree::cli
