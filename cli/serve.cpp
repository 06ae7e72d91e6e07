#include <cli/serve.hpp>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>

#include <httplib.h>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <momentree/base/error.hpp>

extern char** environ;

namespace momentree::cli {

namespace {

/// Shows the address in the user's browser where there is a screen; says nothing where there is none.
void show_in_browser(const std::string& address) {
#ifdef __APPLE__
  const char* program = "open";
#else
  const char* program = "xdg-open";
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
#endif
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", 1 /* O_WRONLY */, 0);
  std::string name = program, argument = address;
  std::array<char*, 3> arguments = {name.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, program, &quiet, nullptr, arguments.data(), environ) == 0)
    std::thread([child] { waitpid(child, nullptr, 0); }).detach();
  posix_spawn_file_actions_destroy(&quiet);
}

/// By names of this machine alone, at this port: else another site may have its name lead here.
bool is_this_machine(std::string_view host, const std::string& port) {
  for (const char* name : {"127.0.0.1:", "localhost:"})
    if (host == name + port) return true;
  return false;
}

bool is_welcome(const httplib::Request& request, const std::string& port) {
  if (!is_this_machine(request.get_header_value("Host"), port)) return false;
  const std::string origin = request.get_header_value("Origin"), scheme = "http://";
  return origin.empty() || (origin.starts_with(scheme) && is_this_machine(origin.substr(scheme.size()), port));
}

}  // namespace

int serve(const Page& page, int port, bool open_browser) {
  httplib::Server server;
  const int bound = port == 0 ? server.bind_to_any_port("127.0.0.1") : (server.bind_to_port("127.0.0.1", port) ? port : -1);
  if (bound <= 0) fail({"port " + std::to_string(port) + " is not to be had", "--port", "leave it out, and a free one is taken"});
  const std::string number = std::to_string(bound);

  server.set_default_headers({{"Content-Security-Policy", page.policy + "; frame-ancestors 'none'"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cross-Origin-Resource-Policy", "same-origin"},
                              {"Cache-Control", "no-store"}});
  server.set_pre_routing_handler([&number](const httplib::Request& request, httplib::Response& response) {
    if (is_welcome(request, number)) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    response.set_content("This page is for the browser of this machine alone.\n", "text/plain");
    return httplib::Server::HandlerResponse::Handled;
  });
  server.Get("/", [&page](const httplib::Request&, httplib::Response& response) {
    response.set_content(page.html, "text/html; charset=utf-8");
  });

  const InterruptGuard guard;
  std::thread listener([&server] { server.listen_after_bind(); });
  const std::string address = "http://127.0.0.1:" + number + "/";
  std::printf("%s\n", address.c_str());
  if (std::fflush(stdout) != 0) {  // nobody would find the page
    server.stop();
    listener.join();
    return failed;
  }
  std::fprintf(stderr, "Ctrl-C ends it\n");
  if (open_browser) show_in_browser(address);
  while (!InterruptGuard::interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  server.stop();
  listener.join();
  return done;
}

}  // namespace momentree::cli
