// The server with clients that do not behave like browsers: each case opens its own sockets.
#include <atomic>
#include <thread>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/live/page_server.hpp>
#include <momentree/live/test_client.hpp>

using namespace momentree;
using namespace momentree::live;
using momentree::live::test::Client;
using momentree::live::test::wait_until;
using namespace std::chrono_literals;

namespace {

/// A server in a thread, with a page of that size.
class Served {
 public:
  explicit Served(std::size_t size = 100'000, const Limits& limits = {}) : page_(size, 'x') {
    Listener listener = listen_on(0);
    port_ = listener.port;
    thread_ = std::thread([this, limits, listener = std::move(listener)]() mutable {
      PageServer server(std::move(listener), {page_, "default-src 'none'", "key", "", std::to_string(port_)}, limits);
      server.run([this, &server] {
        connections_ = server.connections();
        return stop_.load();
      });
    });
  }
  ~Served() {
    stop_ = true;
    thread_.join();
  }
  const std::string& page() const { return page_; }
  int port() const { return port_; }
  std::string request() const { return "GET /key HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\n"; }
  std::size_t connections() const { return connections_; }

 private:
  std::string page_;
  int port_ = 0;
  std::atomic<std::size_t> connections_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

std::string answer(const Served& served, const std::string& text) {
  const Client client(served.port());
  client.send(text);
  return client.receive();
}
std::string status(const std::string& answer) { return answer.size() > 12 ? answer.substr(9, 3) : "none"; }
std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

}  // namespace

TEST_CASE("server: sends the whole page, whatever ranges are requested") {
  const Served served(5'000'000);
  CHECK(body(answer(served, served.request() + "\r\n")) == served.page());
  std::string ranges = "Range: bytes=0-";
  for (int i = 0; i < 900; ++i) ranges += ",0-";
  const std::string all = answer(served, served.request() + ranges + "\r\n\r\n");
  CHECK(status(all) == "200");
  CHECK(body(all) == served.page());
}

TEST_CASE("server: a head may arrive byte by byte") {
  const Served served;
  const Client client(served.port());
  for (const char c : served.request() + "\r\n") REQUIRE(client.send(std::string(1, c)));
  CHECK(body(client.receive()) == served.page());
}

TEST_CASE("server: a body is refused before it arrives, and is not stored") {
  const Served served;
  const Client client(served.port());
  client.send("POST /key HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(served.port()) + "\r\nContent-Length: 300000000\r\n\r\n");
  CHECK(status(client.receive()) == "413");
  wait_until([&] { return !client.send(std::string(100'000, 'x')); });  // it has closed, and no longer reads
}

TEST_CASE("server: a head that is too large is refused, and so are invalid requests") {
  const Served served;
  CHECK(status(answer(served, served.request() + "A: " + std::string(100'000, 'x'))) == "431");
  CHECK(status(answer(served, served.request() + "A: " + std::string(17'000, 'x') + "\r\n\r\n")) == "431");
  CHECK(status(answer(served, "hello\r\n\r\n")) == "400");
  CHECK(status(answer(served, std::string("\x16\x03\x01\x02\x00\n\n", 7))) == "400");  // for example TLS
}

TEST_CASE("server: slow and idle connections are closed, even if they send a little") {
  Limits limits;
  limits.request = 300ms;
  const Served served(100, limits);
  const Client silent(served.port()), slow(served.port());
  CHECK(silent.receive().empty());
  std::thread drip([&slow, &served] {
    for (const char c : served.request() + "A: " + std::string(10'000, 'x')) {
      if (!slow.send(std::string(1, c))) break;
      std::this_thread::sleep_for(10ms);
    }
  });
  CHECK(slow.receive().empty());
  drip.join();
  wait_until([&] { return served.connections() == 0; });
}

TEST_CASE("server: a client that receives none of its reply is dropped") {
  Limits limits;
  limits.stall = 300ms;
  const Served served(50'000'000, limits);
  const Client client(served.port(), 4096);
  client.send(served.request() + "\r\n");
  wait_until([&] { return served.connections() == 1; });
  wait_until([&] { return served.connections() == 0; });
  CHECK(client.receive().size() < served.page().size());
}

TEST_CASE("server: thousands of requests that never end do not keep others from the page") {
  Limits limits;
  limits.request = std::chrono::hours(1);
  const Served served(2'000'000, limits);
  std::vector<Client> idle, greedy;
  for (int i = 0; i < 400; ++i) {
    idle.emplace_back(served.port());
    idle.back().send(served.request());
    if (i % 50 == 0) CHECK(body(answer(served, served.request() + "\r\n")) == served.page());
  }
  CHECK(served.connections() <= limits.connections);
  for (int i = 0; i < 300; ++i) {  // clients that send a request but receive nothing
    greedy.emplace_back(served.port(), 4096);
    greedy.back().send(served.request() + "\r\n");
    if (i % 50 == 0) CHECK(body(answer(served, served.request() + "\r\n")) == served.page());
  }
  CHECK(body(answer(served, served.request() + "\r\n")) == served.page());
}

TEST_CASE("server: a port in use is an error that names a free one, and a port is free again when its server has ended") {
  int port = 0;
  {
    const Served served;
    port = served.port();
    CHECK(status(answer(served, served.request() + "\r\n")) == "200");
    try {
      listen_on(port);
      FAIL("two on one port");
    } catch (const Error& error) {
      CHECK(error.where == "--port");
      CHECK(error.problem == "port " + std::to_string(port) + " is in use");
      const int other = std::stoi(error.hint.substr(5));
      CHECK(listen_on(other).port == other);
    }
  }
  CHECK(listen_on(port).port == port);
}
