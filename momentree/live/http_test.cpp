#include <momentree/live/http.hpp>

#include <doctest/doctest.h>

using namespace momentree::live;

namespace {

Site site() { return {"<html>", "default-src 'none'", "key", "", "80"}; }

/// The reply to a request for the page, with these header lines added.
std::string status(const std::string& first, const std::string& lines, Site of = site()) {
  const std::string head = first + " HTTP/1.1\r\n" + lines + "\r\n";
  CHECK(head_size(head) == head.size());
  const std::optional<HttpRequest> request = parse_head(head);
  return request ? reply_to(*request, of).head.substr(9, 3) : "bad";
}

const std::string host = "Host: 127.0.0.1:80\r\n";

}  // namespace

TEST_CASE("http: a head ends with an empty line, however its bytes come") {
  const std::string head = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
  for (std::size_t size = 0; size < head.size(); ++size) CHECK(head_size(std::string_view(head).substr(0, size)) == head.npos);
  CHECK(head_size(head + "body") == head.size());
  for (std::size_t before = 0; before < head.size(); ++before) CHECK(head_size(head, before) == head.size());
  CHECK(head_size("GET / HTTP/1.1\nHost: a\n\nbody") == 24);
}

TEST_CASE("http: a request is its method, its path without the query, and the headers that count") {
  const auto request = parse_head("GET /a?b=c HTTP/1.1\r\nhOST:  localhost:1 \r\nOrigin:http://x\r\nX: y\r\n\r\n");
  REQUIRE(request);
  CHECK(request->method == "GET");
  CHECK(request->path == "/a");
  CHECK(request->host == "localhost:1");
  CHECK(request->origin == "http://x");
  CHECK_FALSE(request->has_body);
  CHECK(parse_head("GET / HTTP/1.1\r\nContent-Length: 1\r\n\r\n")->has_body);
  CHECK(parse_head("GET / HTTP/1.1\r\nContent-Length: 0, 5\r\n\r\n")->has_body);
  CHECK_FALSE(parse_head("GET / HTTP/1.1\r\nContent-Length: 0\r\n\r\n")->has_body);
  CHECK(parse_head("GET / HTTP/1.1\r\ntransfer-encoding: chunked\r\n\r\n")->has_body);
}

TEST_CASE("http: invalid and ambiguous requests are refused") {
  for (const char* first : {"", "GET", "GET /", "GET / HTTP/2", "GET  HTTP/1.1", "GET http://a/ HTTP/1.1", "GET /a b HTTP/1.1",
                            "G T / HTTP/1.1", "GET /\x01 HTTP/1.1", " / HTTP/1.1"})
    CHECK_FALSE(parse_head(std::string(first) + "\r\nHost: a\r\n\r\n"));
  for (const char* line : {"Host", ": a", "Ho st: a", "Host : a", " Host: a", "Host: a\r\n b", "A: b\rc", "A: b\x7f",
                           "Host: a\r\nHost: a", "Origin: a\r\norigin: a"})
    CHECK_FALSE(parse_head("GET / HTTP/1.1\r\n" + std::string(line) + "\r\n\r\n"));
  CHECK_FALSE(parse_head(std::string("GET / HTTP/1.1\r\nA: b\0c\r\n\r\n", 26)));
}

TEST_CASE("http: the page is for this machine's browser, by GET or HEAD, under its key") {
  CHECK(status("GET /key", host) == "200");
  CHECK(status("HEAD /key", host) == "200");
  CHECK(status("GET /key", "Host: localhost:80\r\nOrigin: http://127.0.0.1:80\r\n") == "200");
  for (const char* path : {"/", "/kez", "/keyy", "/ke", "/key/", "//key"})
    CHECK(status("GET " + std::string(path), host) == "404");
  for (const char* other : {"", "Host: 127.0.0.1\r\n", "Host: 127.0.0.1:8\r\n", "Host: 127.0.0.1:800\r\n", "Host: a:80\r\n"})
    CHECK(status("GET /key", other) == "403");
  for (const char* other : {"http://a:80", "https://127.0.0.1:80", "null"})
    CHECK(status("GET /key", host + "Origin: " + other + "\r\n") == "403");
  CHECK(status("POST /key", host) == "405");
  CHECK(status("POST /key", host + "Content-Length: 5\r\n") == "413");
  CHECK(status("GET /key", host + "Transfer-Encoding: chunked\r\n") == "413");
}

TEST_CASE("http: a range is ignored, HEAD has the length without the page, every reply has the policy and ends the connection") {
  Site of = site();
  const auto reply = [&of](const std::string& method, const std::string& lines) {
    return reply_to(*parse_head(method + " /key HTTP/1.1\r\n" + host + lines + "\r\n"), of);
  };
  const Reply page = reply("GET", "Range: bytes=0-1,0-1,0-1\r\n"), head = reply("HEAD", "");
  CHECK(page.body == "<html>");
  CHECK(head.body.empty());
  CHECK(page.head == head.head);
  CHECK(page.head.find("\r\nContent-Length: 6\r\n") != std::string::npos);
  for (const int code : {400, 403, 404, 405, 413, 431}) {
    const std::string refused = refusal(of, code).head;
    CHECK(refused.find("\r\nContent-Security-Policy: default-src 'none'; frame-ancestors 'none'\r\n") != std::string::npos);
    CHECK(refused.find("\r\nConnection: close\r\n") != std::string::npos);
  }
}

TEST_CASE("http: the address that the browser is started with leads to the page once") {
  Site of = site();
  of.once = "once";
  const auto reply = [&of](const std::string& method) {
    return reply_to(*parse_head(method + " /once HTTP/1.1\r\n" + host + "\r\n"), of).head;
  };
  for (const char* method : {"GET", "HEAD"}) {  // any client that learns the key uses the address up
    of.once = "once";
    const std::string first = reply(method);
    CHECK(first.substr(9, 3) == "303");
    CHECK(first.find("\r\nLocation: /key\r\n") != std::string::npos);
    CHECK(reply("GET").substr(9, 3) == "404");
  }
  CHECK(status("GET /", host, of) == "404");  // an empty path does not match an empty key
}
