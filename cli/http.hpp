#pragma once
// As much of HTTP/1.1 (RFC 9110, 9112) as one page for this machine's browser needs: what a request's head asks for, and the
// reply. No body is ever read, ranges are ignored, and every reply ends its connection.
#include <optional>
#include <string>
#include <string_view>

namespace momentree::cli {

struct HttpRequest {
  std::string method;
  std::string path;    ///< of the target, without its query
  std::string host;    ///< empty: none
  std::string origin;  ///< empty: none
  bool has_body = false;
};

/// The size of the head that `received` begins with, its empty line included; npos: it has not ended yet. It had not ended
/// within the first `before` bytes.
std::size_t head_size(std::string_view received, std::size_t before = 0);

/// nullopt: it is no head of a request, or an ambiguous one.
std::optional<HttpRequest> parse_head(std::string_view head);

/// The one page, and who may see it.
struct Site {
  std::string html;
  std::string policy;  ///< value of its Content-Security-Policy
  std::string key;     ///< the page is at /KEY: other users of this machine don't know it
  std::string once;    ///< leads to the page once; empty: no such path
  std::string port;    ///< as Host and Origin have it
};

struct Reply {
  std::string head;
  std::string_view body;  ///< of the site's page, or of static text
};

/// A refusal by its status: 400, 403, …
Reply refusal(const Site& site, int status);

/// Uses up `site.once`.
Reply reply_to(const HttpRequest& request, Site& site);

}  // namespace momentree::cli
