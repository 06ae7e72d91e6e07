#include "command.hpp"

#include <nanobind/stl/vector.h>

#include <array>
#include <cli/program.hpp>
#include <csignal>
#include <string>
#include <vector>

namespace momentree::python {

namespace {

// Signals as they are for a program outside Python: Ctrl-C and a closed pipe end it. A run handles Ctrl-C itself.
class ProgramSignals {
 public:
  ProgramSignals() {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      sigaction(numbers[i], nullptr, &before_[i]);
      // Python ignores SIGPIPE. Where SIGINT is ignored, somebody else wants that, like a shell that started it with &.
      if (numbers[i] == SIGPIPE || before_[i].sa_handler != SIG_IGN) std::signal(numbers[i], SIG_DFL);
    }
  }
  ~ProgramSignals() {
    for (std::size_t i = 0; i < numbers.size(); ++i) sigaction(numbers[i], &before_[i], nullptr);
  }
  ProgramSignals(const ProgramSignals&) = delete;
  ProgramSignals& operator=(const ProgramSignals&) = delete;

 private:
  static constexpr std::array numbers{SIGINT, SIGTERM, SIGPIPE};
  std::array<struct sigaction, numbers.size()> before_{};
};

int main_of(const std::vector<nanobind::bytes>& given) {
  std::vector<std::string> arguments;
  for (const nanobind::bytes& argument : given) arguments.emplace_back(argument.c_str(), argument.size());
  const nanobind::gil_scoped_release released;
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const ProgramSignals signals;
  return cli::program(static_cast<int>(arguments.size()), argv.data(), cli::bench, commit());
}

}  // namespace

void bind_command(nanobind::module_& m) {
  m.def("main", main_of, nanobind::arg("argv"),
        "Run the command with these arguments, the first of which is the program's name, and return its exit code.");
}

}  // namespace momentree::python
