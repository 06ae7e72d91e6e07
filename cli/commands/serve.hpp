#pragma once
// Serves a page to its user's browser on this machine.
#include <string>

#include <momentree/live/listener.hpp>

namespace momentree::cli {

struct Page {
  std::string html;
  std::string policy;  ///< value of its Content-Security-Policy
};

/// Serves on 127.0.0.1 until Ctrl-C: prints the address, and opens it in a browser if `open_browser`. The address ends with a
/// random key, so that other users of this machine cannot read the page. Requests for another host, or from a page of another
/// origin, are refused, so that no other web page can read this one. Returns the exit code.
int serve(Page page, live::Listener listener, bool open_browser);

}  // namespace momentree::cli
