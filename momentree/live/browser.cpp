#include <momentree/live/browser.hpp>

#include <spawn.h>
#include <sys/random.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string_view>
#include <thread>

#include <momentree/base/error.hpp>

extern char** environ;

namespace momentree::live {

namespace {
#ifdef __APPLE__
constexpr const char* opener = "open";
constexpr bool always = true;
#else
constexpr const char* opener = "xdg-open";
constexpr bool always = false;
#endif
}  // namespace

bool has_screen() { return always || std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }

void open_in_browser(const std::string& address) {
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", 1 /* O_WRONLY */, 0);
  std::string name = opener, argument = address;
  std::array<char*, 3> arguments = {name.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, opener, &quiet, nullptr, arguments.data(), environ) == 0)
    std::thread([child] { waitpid(child, nullptr, 0); }).detach();
  posix_spawn_file_actions_destroy(&quiet);
}

std::string random_key() {
  std::array<unsigned char, 16> bytes;
  if (getentropy(bytes.data(), bytes.size()) != 0) throw_error({"this system provides no random numbers", "", ""});
  std::string key;
  for (const unsigned char byte : bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    key += digits[byte >> 4];
    key += digits[byte & 15];
  }
  return key;
}

}  // namespace momentree::live
