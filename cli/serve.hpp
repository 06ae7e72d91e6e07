#pragma once
// A page on this machine alone, for its user's browser.
#include <string>

namespace momentree::cli {

struct Page {
  std::string html;
  std::string policy;  ///< value of its Content-Security-Policy
};

/// Answers on 127.0.0.1 until Ctrl-C: prints the address, opens it in a browser unless told not to. `port` 0: any that is free.
/// Requests for another host, or from a page of another origin, are refused: no other page on the network can read this one.
/// Exit code. Throws Error where the port is not to be had.
int serve(const Page& page, int port, bool open_browser);

}  // namespace momentree::cli
