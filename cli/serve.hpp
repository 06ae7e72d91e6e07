#pragma once
// A page on this machine alone, for its user's browser.
#include <string>

#include <cli/listener.hpp>

namespace momentree::cli {

struct Page {
  std::string html;
  std::string policy;  ///< value of its Content-Security-Policy
};

/// Answers on 127.0.0.1 until Ctrl-C: prints the address, opens it in a browser unless told not to. The address ends with a key
/// that is new each time, so that other users of this machine can't read the page. Requests for another host, or from a page of
/// another origin, are refused: no other page on the network can read this one. Exit code.
int serve(Page page, Listener listener, bool open_browser);

}  // namespace momentree::cli
