// `momentree bench` is a program of its own, momentree-measure: the batches and benchmark models that it contains would double
// the time to build momentree. It accepts the same command line.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <cli/commands.hpp>
#include <momentree/base/error.hpp>

namespace momentree::cli {

int bench(const BenchOptions& options) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  fs::path program = folder / "momentree-measure";                                                // in a build
  if (!fs::exists(program, ignored)) program = folder / MOMENTREE_LIBEXEC / "momentree-measure";  // installed
  std::fflush(nullptr);
  execv(program.c_str(), options.command_line);
  const std::string why = std::strerror(errno);
  throw_error(
      {"cannot start momentree-measure, which does the measurements: " + why, program.string(), "`./dev build` builds it"});
}

}  // namespace momentree::cli
