#include <cli/serve.hpp>

#include <cstdio>
#include <string>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <momentree/live/browser.hpp>
#include <momentree/live/page_server.hpp>

namespace momentree::cli {

int serve(Page page, live::Listener listener, bool open_browser) {
  const std::string port = std::to_string(listener.port), site_address = "http://127.0.0.1:" + port + "/";
  live::Site site{std::move(page.html), std::move(page.policy), live::random_key(), "", port};
  const std::string address = site_address + site.key;
  const bool opens = open_browser && live::has_screen();
  if (opens) site.once = live::random_key();
  const std::string once = site_address + site.once;

  const InterruptGuard guard;
  std::printf("%s\n", address.c_str());
  if (std::fflush(stdout) != 0) return failed;  // nobody would find the page
  std::fprintf(stderr, "Press Ctrl-C to stop.\n");
  // Other users can see the arguments of the browser's process, so the browser gets an address that works once.
  if (opens) live::open_in_browser(once);
  live::PageServer(std::move(listener), std::move(site)).run(InterruptGuard::interrupted);
  return done;
}

}  // namespace momentree::cli
