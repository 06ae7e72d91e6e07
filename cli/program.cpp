// Turns errors into messages and exit codes. The command line itself is in command_line.cpp. No physics.
#include <cli/program.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include <cli/command_line.hpp>
#include <cli/exit_codes.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::cli {

namespace {

// Prints the parts separately, since there may be no memory to join them.
void print_error(const Error& error) {
  const bool placed = !error.where.empty(), hinted = !error.hint.empty();
  if (const auto* const file = dynamic_cast<const io::InputError*>(&error)) return show(stderr, std::string(file->what()) + '\n');
  try {
    show(stderr, (placed ? "" : "momentree: ") + error.message() + '\n');
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: error: %s%s%s\n", placed ? error.where.c_str() : "momentree", error.problem.c_str(),
                 hinted ? "; " : "", error.hint.c_str());
  }
}

// A file opened while a standard stream is closed would get its number, and printed text would go into it.
void require_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF) [[maybe_unused]]
      const int number = open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // so that using it fails
}

}  // namespace

int program(int argc, char** argv, Bench bench, std::string_view commit) {
  require_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // exceeding the limit on file sizes then gives a write error
  int code = failed;
  try {
    code = call(argc, argv, bench, commit);
  } catch (const Error& error) {
    code = bad_input;
    print_error(error);
  } catch (const std::bad_alloc&) {
    std::fputs("momentree: error: out of memory; a model takes about 3 kB for each body\n", stderr);
  } catch (const std::exception& error) {
    show(stderr, "momentree: error: " + printable(error.what()) + '\n');
  }
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fprintf(stderr, "momentree: error: cannot write to standard output%s%s\n", errno != 0 ? ": " : "",
                 errno != 0 ? std::strerror(errno) : "");
    if (code == done) code = failed;
  }
  return code;
}

}  // namespace momentree::cli
