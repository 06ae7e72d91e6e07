#include <cli/commands/serve.hpp>

#include <cstdio>
#include <string>

#include <cli/exit_codes.hpp>
#include <cli/interrupt.hpp>
#include <momentree/live/page_server.hpp>

namespace momentree::cli {

int serve(Page page, live::Listener listener, bool open_browser) {
  live::Site site = live::site_of(std::move(page.html), std::move(page.policy), listener.port);
  const InterruptGuard guard;
  std::printf("%s\n", live::address_of(site).c_str());
  if (std::fflush(stdout) != 0) return failed;  // nobody would find the page
  std::fprintf(stderr, "Press Ctrl-C to stop.\n");
  if (open_browser) live::open_in_browser(site);
  live::PageServer(std::move(listener), std::move(site)).run(InterruptGuard::interrupted);
  return done;
}

}  // namespace momentree::cli
