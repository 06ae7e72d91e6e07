#include <cli/serve.hpp>

#include <spawn.h>
#include <sys/random.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <cli/page_server.hpp>
#include <momentree/base/error.hpp>

extern char** environ;

namespace momentree::cli {

namespace {

#ifdef __APPLE__
constexpr const char* opener = "open";
bool has_screen() { return true; }
#else
constexpr const char* opener = "xdg-open";
bool has_screen() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }
#endif

/// Opens the address in the user's browser; failures are ignored.
void show_in_browser(const std::string& address) {
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

/// 128 random bits in hexadecimal digits.
std::string new_key() {
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

}  // namespace

int serve(Page page, Listener listener, bool open_browser) {
  const std::string port = std::to_string(listener.port), site_address = "http://127.0.0.1:" + port + "/";
  Site site{std::move(page.html), std::move(page.policy), new_key(), "", port};
  const std::string address = site_address + site.key;
  const bool opens = open_browser && has_screen();
  if (opens) site.once = new_key();
  const std::string once = site_address + site.once;

  const InterruptGuard guard;
  std::printf("%s\n", address.c_str());
  if (std::fflush(stdout) != 0) return failed;  // nobody would find the page
  std::fprintf(stderr, "Press Ctrl-C to stop.\n");
  // Other users can see the arguments of the browser's process, so the browser gets an address that works once.
  if (opens) show_in_browser(once);
  PageServer(std::move(listener), std::move(site)).run(InterruptGuard::interrupted);
  return done;
}

}  // namespace momentree::cli
