// The command line: turns arguments into options, and errors into messages and exit codes. No physics.
#include <cstdio>
#include <exception>

#include <cli/command_line.hpp>
#include <momentree/base/error.hpp>

int main(int argc, char** argv) {
  using namespace momentree;
  int code = cli::failed;
  try {
    code = cli::CommandLine().call(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.where.empty() ? ("momentree: " + error.message()).c_str() : error.message().c_str());
    code = cli::bad_input;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "momentree: error: %s\n", error.what());
    code = cli::failed;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fputs("momentree: error: cannot write to standard output\n", stderr);
    if (code == cli::done) code = cli::failed;
  }
  return code;
}
