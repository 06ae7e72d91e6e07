#include <momentree/live/http.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/live/browser.hpp>
#include <momentree/live/feed.hpp>

namespace momentree::live {

namespace {

bool same_name(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// tchar of RFC 9110, 5.6.2.
bool is_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) || std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string_view::npos;
  });
}

/// The next line without its end, removed from `text`. A bare LF ends a line, too (RFC 9112, 2.2).
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

/// "GET /path?query HTTP/1.1".
bool parse_first_line(std::string_view line, HttpRequest& request) {
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return false;
  const std::string_view target = line.substr(first + 1, last - first - 1), version = line.substr(last + 1);
  request.method = line.substr(0, first);
  request.path = target.substr(0, target.find('?'));
  return is_token(request.method) && target.starts_with('/') && (version == "HTTP/1.1" || version == "HTTP/1.0") &&
         std::ranges::all_of(target, [](unsigned char c) { return c > ' ' && c != 0x7f; });
}

bool parse_size(std::string_view text, std::size_t& size) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

/// Accepts only names of this machine, at this port: otherwise another site could point its name here (DNS rebinding).
bool is_this_machine(std::string_view host, std::string_view port) {
  for (const std::string_view name : {"127.0.0.1:", "localhost:"})
    if (host.starts_with(name) && host.substr(name.size()) == port) return true;
  return false;
}

bool is_welcome(const HttpRequest& request, const Site& site) {
  constexpr std::string_view scheme = "http://";
  const std::string_view origin = request.origin;
  return is_this_machine(request.host, site.port) &&
         (origin.empty() || (origin.starts_with(scheme) && is_this_machine(origin.substr(scheme.size()), site.port)));
}

/// Compares in constant time, which does not reveal how much of the path is right.
bool is_path(std::string_view path, std::string_view key) {
  if (path.size() != key.size() + 1) return false;
  unsigned char differs = 0;
  for (std::size_t i = 0; i < key.size(); ++i) differs |= static_cast<unsigned char>(path[i + 1] ^ key[i]);
  return differs == 0;
}

struct StatusLine {
  int code;
  std::string_view name, says;
};
constexpr std::array statuses = {
    StatusLine{200, "OK", ""},
    StatusLine{204, "No Content", ""},
    StatusLine{303, "See Other", ""},
    StatusLine{400, "Bad Request", "This is not a request that a browser would send.\n"},
    StatusLine{403, "Forbidden", "The server accepts only same-origin requests from this machine.\n"},
    StatusLine{404, "Not Found", "Open the full address that momentree printed, including the key at its end.\n"},
    StatusLine{405, "Method Not Allowed", "This address does not support that method.\n"},
    StatusLine{413, "Content Too Large", "This address accepts no body, or none of that size.\n"},
    StatusLine{431, "Request Header Fields Too Large", "The head of the request is too large.\n"},
    StatusLine{503, "Service Unavailable", "Too many pages show this program. Close some of them.\n"},
};

/// The lines of every head but those of the body's size.
std::string make_head(const Site& site, const StatusLine& status, std::string_view type) {
  std::string head = "HTTP/1.1 " + std::to_string(status.code) + ' ' + std::string(status.name) + "\r\n";
  head += "Content-Type: " + std::string(type) + "; charset=utf-8\r\n";
  head += "Content-Security-Policy: " + site.policy + "; frame-ancestors 'none'\r\n";
  head += "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n";
  head += "Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\nAccept-Ranges: none\r\n";
  return head + "Connection: close\r\n";
}

Reply make_reply(const Site& site, int code, std::string_view body, std::string_view type, const std::string& more = "") {
  const auto* status = std::ranges::find(statuses, code, &StatusLine::code);
  MT_REQUIRE(status != statuses.end(), "a status that has a name");
  if (body.empty()) body = status->says;
  const std::string size = code == 204 ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n";
  return {make_head(site, *status, type) + size + more + "\r\n", body};
}

/// The beginning of a stream of server-sent events (HTML, 9.2), which lasts until one side closes the connection.
Reply begin_stream(const Site& site) { return {make_head(site, statuses[0], "text/event-stream") + "\r\n", {}, true}; }

bool is_live(const HttpRequest& request, const Site& site, std::string_view what) {
  return site.feed != nullptr && is_path(request.path, site.key + std::string(what));
}

}  // namespace

std::size_t head_size(std::string_view received, std::size_t before) {
  for (std::size_t at = received.find('\n', before - std::min<std::size_t>(before, 2)); at != std::string_view::npos;
       at = received.find('\n', at + 1)) {
    const std::string_view rest = received.substr(at + 1);
    if (rest.starts_with('\n')) return at + 2;
    if (rest.starts_with("\r\n")) return at + 3;
  }
  return std::string_view::npos;
}

std::optional<HttpRequest> parse_head(std::string_view head) {
  HttpRequest request;
  if (!parse_first_line(take_line(head), request)) return std::nullopt;
  bool has_host = false, has_length = false;
  for (std::string_view line = take_line(head); !line.empty(); line = take_line(head)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) return std::nullopt;  // folded lines, too
    const std::string_view name = line.substr(0, colon), value = trimmed(line.substr(colon + 1));
    if (std::ranges::any_of(value, [](unsigned char c) { return (c < ' ' && c != '\t') || c == 0x7f; })) return std::nullopt;
    if (same_name(name, "Host")) {
      if (std::exchange(has_host, true)) return std::nullopt;
      request.host = value;
    } else if (same_name(name, "Origin")) {
      if (!request.origin.empty()) return std::nullopt;
      request.origin = value;
    } else if (same_name(name, "Transfer-Encoding")) {
      if (std::exchange(has_length, true)) return std::nullopt;
      request.has_body = true;
    } else if (same_name(name, "Content-Length")) {
      if (std::exchange(has_length, true) || !parse_size(value, request.body_size)) return std::nullopt;
      request.has_body = request.body_size != 0;
    }
  }
  return request;
}

Site site_of(std::string html, std::string policy, int port, Feed* feed) {
  return {std::move(html), std::move(policy), random_key(), "", std::to_string(port), feed};
}

std::string address_of(const Site& site) { return "http://127.0.0.1:" + site.port + "/" + site.key; }

void open_in_browser(Site& site) {
  if (!has_screen()) return;
  site.once = random_key();
  open_in_browser("http://127.0.0.1:" + site.port + "/" + site.once);
}

Reply refusal(const Site& site, int status) {
  return make_reply(site, status, {}, "text/plain", status == 405 ? "Allow: GET, HEAD\r\n" : "");
}

bool takes_body(const HttpRequest& request, const Site& site) {
  return is_welcome(request, site) && request.method == "POST" && request.body_size <= most_text &&
         (request.body_size > 0 || !request.has_body) && is_live(request, site, "/act");
}

Reply reply_to(const HttpRequest& request, Site& site, std::string_view body) {
  Reply reply;
  if (!is_welcome(request, site)) {
    reply = refusal(site, 403);
  } else if (takes_body(request, site)) {
    site.feed->receive(body);
    reply = make_reply(site, 204, {}, "text/plain");
  } else if (request.has_body) {
    reply = refusal(site, 413);
  } else if (request.method != "GET" && request.method != "HEAD") {
    reply = refusal(site, 405);
  } else if (is_path(request.path, site.key)) {
    reply = make_reply(site, 200, site.html, "text/html");
  } else if (is_live(request, site, "/stream")) {
    reply = begin_stream(site);
  } else if (!site.once.empty() && is_path(request.path, site.once)) {
    reply = make_reply(site, 303, {}, "text/plain", "Location: /" + site.key + "\r\n");
    site.once.clear();  // any client that learns the key, by HEAD too, uses the address up
  } else {
    reply = refusal(site, 404);
  }
  if (request.method == "HEAD") reply.body = {}, reply.streams = false;
  return reply;
}

}  // namespace momentree::live
