// `momentree view` and `play` as processes: their port, their address, their end.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/live/listener.hpp>

using namespace momentree;

namespace {

/// The program with these arguments; it is terminated by the destructor.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    std::array<int, 2> out, err;
    REQUIRE(pipe(out.data()) == 0);
    REQUIRE(pipe(err.data()) == 0);
    std::vector<char*> words;
    arguments.insert(arguments.begin(), "momentree");
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    child_ = fork();
    if (child_ == 0) {
      dup2(out[1], STDOUT_FILENO);
      dup2(err[1], STDERR_FILENO);
      for (const int end : {out[0], out[1], err[0], err[1]}) close(end);
      execv(MOMENTREE_PROGRAM, words.data());
      _exit(127);
    }
    close(out[1]);
    close(err[1]);
    out_ = fdopen(out[0], "r");
    err_ = fdopen(err[0], "r");
  }
  ~Process() {
    if (child_ > 0) end(SIGKILL);
    std::fclose(out_);
    std::fclose(err_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  std::string output_line() { return line(out_); }
  std::string error_line() { return line(err_); }
  /// Its exit code; −1: it was killed.
  int end(int signal = 0) {
    if (signal != 0) kill(child_, signal);
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  static std::string line(FILE* stream) {
    std::string text;
    for (int c; (c = std::fgetc(stream)) != EOF && c != '\n';) text += static_cast<char>(c);
    return text;
  }
  pid_t child_;
  FILE *out_, *err_;
};

const std::string scenario = MOMENTREE_SOURCE_DIR "/scenarios/pendulum.toml";

std::string number_before(const std::string& text, const std::string& end) {
  const std::size_t at = text.find(end), from = text.rfind(' ', at - 1);
  REQUIRE(at != std::string::npos);
  return text.substr(from + 1, at - from - 1);
}

}  // namespace

TEST_CASE("serve: of two programs on one port the second fails and names a free port, which it can have") {
  Process first({"play", "--no-browser"});
  const std::string address = first.output_line();
  REQUIRE(address.starts_with("http://127.0.0.1:"));
  const std::string port = address.substr(17, address.find('/', 17) - 17);
  for (const char* command : {"view", "play"}) {
    Process second({command, scenario, "--no-browser", "--port", port});
    CHECK(second.output_line().empty());
    const std::string error = second.error_line();
    CHECK(error.starts_with("--port: error: port " + port + " is in use; port "));
    CHECK(second.end() == 2);
    const std::string other = number_before(error, " is free");
    Process third({command, scenario, "--no-browser", "--port", other});
    CHECK(third.output_line().starts_with("http://127.0.0.1:" + other + "/"));
    CHECK(third.end(SIGINT) == 0);
  }
  CHECK(first.end(SIGTERM) == 0);
}

TEST_CASE("serve: an address is new each time, and its port is free again at once") {
  Process first({"play", "--no-browser"});
  const std::string address = first.output_line();
  CHECK(first.error_line() == "Press Ctrl-C to stop.");
  const std::string key = address.substr(address.rfind('/') + 1);
  CHECK(key.size() == 32);
  CHECK(key.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(first.end(SIGINT) == 0);
  const std::string port = address.substr(17, address.find('/', 17) - 17);
  Process second({"play", "--no-browser", "--port", port});
  const std::string again = second.output_line();
  CHECK(again.substr(0, again.rfind('/')) == address.substr(0, address.rfind('/')));
  CHECK(again != address);
  CHECK(second.end(SIGINT) == 0);
}

TEST_CASE("serve: a port in use is reported before a scenario is run") {
  const live::Listener taken = live::listen_on(0);
  Process view({"view", "no such file.toml", "--no-browser", "--port", std::to_string(taken.port)});
  CHECK(view.error_line().find("is in use") != std::string::npos);
  CHECK(view.end() == 2);
}
