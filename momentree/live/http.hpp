#pragma once
// The part of HTTP/1.1 (RFC 9110, 9112) that one page for a browser on this machine needs: parsing request heads, and replies.
// Bodies are read only by the path of a live page, ranges are ignored, and every reply closes its connection.
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace momentree::live {

class Feed;

/// The largest text that a live page may send (bytes).
inline constexpr std::size_t most_text = 64 * 1024;

struct HttpRequest {
  std::string method;
  std::string path;    ///< of the target, without its query
  std::string host;    ///< empty: none
  std::string origin;  ///< empty: none
  bool has_body = false;
  std::size_t body_size = 0;  ///< of a body with a stated length (bytes)
};

/// The size of the head at the start of `received`, including its empty line; npos if it is incomplete. `before`: the number of
/// bytes that are known not to contain the whole head.
std::size_t head_size(std::string_view received, std::size_t before = 0);

/// nullopt if it is not a valid request head, or is ambiguous.
std::optional<HttpRequest> parse_head(std::string_view head);

/// The one page, and the conditions for serving it.
struct Site {
  std::string html;
  std::string policy;    ///< value of its Content-Security-Policy
  std::string key;       ///< the page is at /KEY, which other users of this machine do not know
  std::string once;      ///< a path that redirects to the page once; empty: no such path
  std::string port;      ///< as in the Host and Origin headers
  Feed* feed = nullptr;  ///< of a live page: /KEY/stream sends its messages as events, /KEY/act takes texts
};

/// A page on this port with a new key.
Site site_of(std::string html, std::string policy, int port, Feed* feed = nullptr);
/// The address of a site's page.
std::string address_of(const Site& site);
/// Opens the page in the user's browser, where there is a screen. Other users can see the arguments of the browser's process, so
/// it gets an address that works once.
void open_in_browser(Site& site);

struct Reply {
  std::string head;
  std::string_view body;  ///< the site's page, or static text
  bool streams = false;   ///< messages of the feed follow
};

/// An error reply by its status: 400, 403, …
Reply refusal(const Site& site, int status);

/// Whether the body of this request is for the site's feed.
bool takes_body(const HttpRequest& request, const Site& site);

/// Clears `site.once` once it is used. `body`: complete, if takes_body().
Reply reply_to(const HttpRequest& request, Site& site, std::string_view body = {});

}  // namespace momentree::live
