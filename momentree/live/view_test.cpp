// The live view, read and controlled as a page does it.
#include <momentree/live/view.hpp>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <thread>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/base/error.hpp>
#include <momentree/live/feed.hpp>
#include <momentree/live/test_client.hpp>
#include <momentree/momentree.hpp>
#include <momentree/pages/page_world.hpp>
#include <momentree/results/session.hpp>
#include <momentree/text/base64.hpp>

using namespace momentree;
using namespace momentree::live;
using nlohmann::json;

namespace {

/// A chain of two links that swing about the y axis.
Model chain() {
  Model model;
  BodySpec link{
      .name = "upper", .mass = 1, .com = {0, 0, -0.5}, .inertia = diagonal(0.1, 0.1, 0.01), .joint = Revolute{{0, 1, 0}}};
  link.q = {0.7};
  const BodyId upper = model.add(link);
  link.name = "lower", link.parent = upper, link.at = Pose{{0, 0, -1}, {}};
  model.add(link);
  return model;
}

/// A page: receives the events of a view and sends texts.
class Page {
 public:
  explicit Page(const View& view)
      : port_(std::stoi(view.address().substr(view.address().rfind(':') + 1))),
        path_(view.address().substr(view.address().find('/', 8))),
        stream_(port_) {
    stream_.send("GET " + path_ + "/stream HTTP/1.1\r\n" + host() + "\r\n");
    head = stream_.receive_to("\r\n\r\n");
  }
  std::string host() const { return "Host: 127.0.0.1:" + std::to_string(port_) + "\r\n"; }
  /// The next message; empty beats are skipped.
  json next() {
    for (;;) {
      const std::string event = stream_.receive_to("\n\n");
      if (event.empty()) return json();
      if (event.starts_with("data: ")) return json::parse(event.substr(6));
    }
  }
  /// The next message of a type.
  json next(const std::string& type) {
    for (;;) {
      json message = next();
      if (message.is_null() || message["type"] == type) return message;
    }
  }
  /// The status of the reply.
  std::string act(const std::string& text, const std::string& more = {}) const {
    const Client client(port_);
    client.send("POST " + path_ + "/act HTTP/1.1\r\n" + host() + more + "Content-Length: " + std::to_string(text.size()) +
                "\r\n\r\n" + text);
    return client.receive().substr(9, 3);
  }
  int port() const { return port_; }
  std::string head;

 private:
  using Client = test::Client;
  int port_;
  std::string path_;
  Client stream_;
};

std::array<double, io::totals_size> totals_of(const json& frame) {
  const std::string bytes = io::from_base64(frame["numbers"].get<std::string>()).value();
  std::array<double, io::totals_size> totals;
  REQUIRE(bytes.size() >= sizeof totals);
  std::memcpy(totals.data(), bytes.data(), sizeof totals);
  return totals;
}

const ViewOptions quiet{.title = "Chain", .open_browser = false};

}  // namespace

TEST_CASE("live: a page gets the world, and frames of the state that it has") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  CHECK(page.head.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream"));
  const json loaded = page.next();
  REQUIRE(loaded["type"] == "loaded");
  CHECK(loaded["world"]["model"]["title"] == "Chain");
  CHECK(loaded["world"]["topology"]["joints"].size() == 2);
  CHECK(totals_of(loaded["world"]["frame"])[0] == 0);
  CHECK(page.next()["type"] == "events");
  CHECK(page.next()["type"] == "sliders");
  CHECK(page.next()["on"] == true);
  REQUIRE(sim.run_until(0.25));
  view.exchange();
  const json frame = page.next("frame")["frame"];
  CHECK(totals_of(frame)[0] == 0.25);
  CHECK(totals_of(frame)[1] == doctest::Approx(sim.world().totals().kinetic).epsilon(1e-15));
  CHECK(view.pages() == 1);
}

TEST_CASE("live: a page that opens later gets the present world with all events") {
  Simulation sim(chain());
  View view(sim, quiet);
  sim.apply(lock("lower"));
  view.exchange();
  REQUIRE(sim.run_until(0.1));
  sim.apply(break_joint("lower"));
  view.exchange();
  Page page(view);
  CHECK(page.next()["world"]["topology"]["mechanisms"].size() == 2);
  const json events = page.next();
  REQUIRE(events["events"].size() == 2);
  CHECK(events["events"][1]["time"] == 0.1);
}

TEST_CASE("live: what the reader does happens between two steps, each with its certificate") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  page.next("playing");
  CHECK(page.act(R"({"type": "act", "action": {"lock": "lower"}})") == "204");
  CHECK(page.act(R"({"type": "act", "action": {"weld": {"body": "lower"}}})") == "204");
  CHECK(page.act(R"({"type": "act", "action": {"break": "upper"}})") == "204");
  CHECK(page.act(R"({"type": "gravity", "value": [0, 0, -1.5]})") == "204");
  CHECK(sim.events().empty());  // the program has not looked
  view.exchange();
  REQUIRE(sim.events().size() == 3);
  CHECK(sim.world().model().gravity() == Vec3{0, 0, -1.5});
  CHECK(page.next("topology")["topology"]["joints"].is_array());
  CHECK(page.next("events")["events"].size() == 3);
  page.act(R"({"type": "act", "action": {"break": "seventh"}})");
  view.exchange();
  CHECK(page.next("refused")["message"].get<std::string>().find("seventh") != std::string::npos);
  CHECK(sim.events().size() == 3);
}

TEST_CASE("live: parameters, damping and sliders") {
  Simulation sim(chain());
  View view(sim, quiet);
  double told = 0;
  view.slider({.name = "wind", .least = 0, .most = 20, .value = 3, .unit = "m/s", .changed = [&told](double v) { told = v; }});
  Page page(view);
  const json sliders = page.next("sliders")["sliders"];
  REQUIRE(sliders.size() == 1);
  CHECK(sliders[0]["value"] == 3);
  page.act(R"({"type": "slider", "name": "wind", "value": 12.5})");
  page.act(R"({"type": "act", "action": {"set": {"joint": "upper", "damping": 0.5, "stiffness": 4}}})");
  view.exchange();
  CHECK(view.value("wind") == 12.5);
  CHECK(told == 12.5);
  CHECK(sim.world().joint({0}).parameters->damping.of(0) == 0.5);
  CHECK(sim.world().joint({0}).parameters->stiffness.of(0) == 4);
  page.act(R"({"type": "slider", "name": "wind", "value": 1e9})");
  page.act(R"({"type": "act", "action": {"set": {"joint": "upper", "damping": -1}}})");
  view.exchange();
  CHECK(view.value("wind") == 20);
  CHECK(page.next("refused")["message"].get<std::string>().find("damping") != std::string::npos);
  CHECK(sim.world().joint({0}).parameters->damping.of(0) == 0.5);
  CHECK_THROWS_AS(view.slider({.name = "wind"}), Error);
  CHECK_THROWS_AS(view.slider({.name = "rain", .least = 2, .most = 1}), Error);
  CHECK_THROWS_AS((void)view.value("rain"), Error);
}

TEST_CASE("live: a body that is grabbed follows the pointer, and its work is accounted for") {
  Simulation sim(chain(), {.step = 1e-3});
  View view(sim, quiet);
  const Page page(view);
  page.act(R"({"type": "grab", "body": "lower", "point": [0, 0, -1], "target": [1.5, 0, -1]})");
  view.exchange();
  REQUIRE(sim.run_until(3));
  const BodyMotion held = sim.world().motions()[1];
  const Vec3 tip = held.pose * Vec3{0, 0, -1};
  CHECK(std::hypot(tip.x - 1.5, tip.z + 1) < 0.2);
  CHECK(std::fabs(sim.energy().work) > 1);
  CHECK(std::fabs(sim.energy().error) < 1e-4 * std::fabs(sim.energy().work));
  page.act(R"({"type": "release"})");
  view.exchange();
  CHECK(sim.world().tree().loads().functions.empty());
  sim.force("lower", [](const EvaluationContext&) { return Wrench{}; });
  page.act(R"({"type": "grab", "body": "lower", "point": [0, 0, -1], "target": [1.5, 0, -1]})");
  view.exchange();
  CHECK(sim.world().tree().loads().functions.size() == 1);  // that of the program
}

TEST_CASE("live: a run at the page's speed takes the steps of a run without a page") {
  Simulation alone(chain()), shown(chain());
  REQUIRE(alone.run_until(0.3));
  View view(shown, {.open_browser = false, .speed = 3});
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(view.run_until(0.3));
  CHECK(std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(80));  // 0.1 s at that speed
  CHECK(shown.time() == 0.3);
  const auto q = [](const Simulation& sim) { return sim.world().state().q(); };
  for (std::size_t i = 0; i < 2; ++i) CHECK(std::fabs(q(alone)[i] - q(shown)[i]) < 1e-13);
}

TEST_CASE("live: steps that are longer than a frame wait for their time") {
  Simulation sim(chain(), {.step = 0.05});
  View view(sim, {.open_browser = false, .speed = 0.5});
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(view.run_until(0.2));
  CHECK(std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(250));  // three waits of 0.1 s
}

TEST_CASE("live: what the program changes between two calls reaches open pages") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  page.next("playing");
  sim.apply(lock("lower"));
  view.slider({.name = "wind"});
  CHECK(page.next("topology")["topology"]["joints"][1]["locked"] == 1);
  CHECK(page.next("events")["events"].size() == 1);
  sim.set_gravity({0, 0, -2});
  view.exchange();
  CHECK(page.next("gravity")["value"] == json({0, 0, -2}));
  const std::vector<double> q{0.1, 0};
  const std::vector<double> p(2, 0.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  sim.adjust(q, p, Variables::velocities);
  view.exchange();
  const double potential = sim.world().totals().potential;
  json frame;  // those before are of the lock and of gravity
  do frame = page.next("frame")["frame"];
  while (std::fabs(totals_of(frame)[2] - potential) > 1e-9);
  Page later(view);
  CHECK(later.next()["world"]["scenario"]["gravity"] == json({0, 0, -2}));
  page.act(R"({"type": "slider", "name": "wind", "value": 0.5})");
  view.exchange();
  CHECK(later.next("sliders")["sliders"][0]["value"] == 0);
  CHECK(later.next("sliders")["sliders"][0]["value"] == 0.5);
}

TEST_CASE("live: a grip that the program replaces ends, and does not take the program's function with it") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  page.next("playing");
  page.act(R"({"type": "grab", "body": "lower", "point": [0, 0, -1], "target": [1.5, 0, -1]})");
  view.exchange();
  sim.force("lower", [](const EvaluationContext&) { return Wrench{}; });
  page.act(R"({"type": "pull", "target": [1, 0, -1]})");
  view.exchange();
  CHECK(page.next("refused")["message"].get<std::string>().find("replaced the grip") != std::string::npos);
  page.act(R"({"type": "release"})");
  view.exchange();
  CHECK(sim.world().tree().loads().functions.size() == 1);
}

TEST_CASE("live: a feed keeps a bounded number of bytes") {
  Feed feed;
  Feed::Reader reader;
  feed.greet({"{}"}, false);
  std::string text;
  feed.append_new(reader, text);
  for (int i = 0; i < 100'000; ++i) feed.post(std::string(1000, 'x'));
  text.clear();
  feed.append_new(reader, text);
  CHECK(text.starts_with("data: {}\n\n"));  // it lacks more than is kept, and begins anew
  CHECK(text.size() < 5'000'000);
}

TEST_CASE("live: pause holds update(), and Stop ends a run") {
  Simulation sim(chain());
  View view(sim, {.open_browser = false, .paused = true});
  const Page page(view);
  std::atomic<int> updates = 0;
  std::atomic<bool> over = false;
  std::thread program([&] {
    while (view.update()) {
      ++updates;
      if (!sim.step(1e-3)) break;
    }
    CHECK(view.run_until(1e3) == Status::interrupted);
    over = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(updates == 0);
  page.act(R"({"type": "play", "on": true})");
  test::wait_until([&] { return updates > 10; });
  page.act(R"({"type": "stop"})");
  test::wait_until([&] { return over.load(); });
  program.join();
  CHECK(view.stopped());
}

TEST_CASE("live: a run that diverges is paused, with its reason on the page") {
  Model model = chain();
  Simulation sim(model, {.step = 0.5});
  sim.drive("upper", [](const EvaluationContext&) { return 1e200; });
  View view(sim, {.open_browser = false, .speed = 100});
  Page page(view);
  const RunResult result = view.run_until(100);
  CHECK_FALSE(result);
  CHECK(page.next("stopped")["message"] == result.reason);
  CHECK_FALSE(view.playing());
}

TEST_CASE("live: a run that went back, and bodies that were added, are a new world for the pages") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  page.next("playing");
  const SimulationSnapshot start = sim.snapshot();
  REQUIRE(sim.run_until(0.2));
  view.exchange();
  sim.restore(start);
  view.exchange();
  CHECK(totals_of(page.next("loaded")["world"]["frame"])[0] == 0);
  sim.add({.name = "ball", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  view.exchange();
  CHECK(page.next("loaded")["world"]["model"]["bodies"].size() == 3);
}

TEST_CASE("live: requests that no page makes are refused") {
  Simulation sim(chain());
  View view(sim, quiet);
  Page page(view);
  page.next("playing");
  CHECK(page.act("{}", "Origin: http://example.com\r\n") == "403");
  CHECK(page.act(std::string(70'000, ' ')) == "413");
  const test::Client wrong(page.port());
  wrong.send("GET /0123/stream HTTP/1.1\r\n" + page.host() + "\r\n");
  CHECK(wrong.receive().substr(9, 3) == "404");
  for (const char* const text :
       {"", "{", "[]", "{\"type\": 3}", "{\"type\": \"play\"}", "{\"type\": \"act\"}", "{\"type\": \"grab\", \"body\": 1e30}",
        "{\"type\": \"gravity\", \"value\": [1, 2]}", "{\"type\": \"rewind\", \"time\": 0}",
        "{\"type\": \"act\", \"action\": {\"weld\": {\"body\": \"upper\", \"to\": \"x\"}}}"}) {
    CHECK(page.act(text) == "204");
    view.exchange();
    CHECK(page.next("refused")["message"] != "");
  }
  CHECK(sim.events().empty());
  CHECK(view.playing());
  CHECK_THROWS_AS(View(sim, {.open_browser = false, .speed = 0}), Error);
}

TEST_CASE("live: sixteen pages may be open") {
  Simulation sim(chain());
  View view(sim, quiet);
  std::vector<std::unique_ptr<Page>> pages;
  for (int i = 0; i < 16; ++i) pages.push_back(std::make_unique<Page>(view));
  for (const auto& page : pages) CHECK(page->head.substr(9, 3) == "200");
  const Page another(view);
  CHECK(another.head.substr(9, 3) == "503");
  pages.pop_back();
  test::wait_until([&] { return Page(view).head.substr(9, 3) == "200"; });
}

TEST_CASE("live: a scenario's view has its title and its loads") {
  io::Session session = io::load_text(R"(
format = 1
title = "Rod"
[[mechanism]]
name = "rod"
[[mechanism.body]]
name = "rod"
mass = 1
com = [0, 0, -0.5]
inertia = 0.1
joint = { name = "pin", kind = "revolute", axis = [0, 1, 0] }
[[event]]
when = { reaction_force = "rod/pin", exceeds = "50 N" }
break = "rod/pin"
)",
                                      "rod.toml");
  View view(session.simulation(), session.scenario(), {.open_browser = false});
  Page page(view);
  const json world = page.next()["world"];
  CHECK(world["model"]["title"] == "Rod");
  CHECK(world["scenario"]["events"].size() == 1);
}
