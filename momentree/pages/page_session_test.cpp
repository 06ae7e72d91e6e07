// A session as a page uses it: messages in, messages out, and what moves meanwhile.
#include <momentree/pages/page_session.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

using namespace momentree;
using namespace momentree::io;
using nlohmann::json;

namespace {

const std::string chain_text = R"(format = 1
[world]
gravity = [0, -9.81, 0]
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 4
length = 0.2
mass = 0.1
inertia = 3e-4
[[event]]
at = 0.3
break = "chain/3"
)";

const std::string hanging_text = R"(format = 1
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 8
length = 0.1
mass = 0.05
inertia = 4e-5
axis = [0, 1, 0]
damping = 0.0002
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

std::string crates() {
  std::ifstream file(MOMENTREE_SOURCE_DIR "/scenarios/hanging_boxes_fall.toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Frame {
  std::array<double, totals_size> totals;
  std::vector<float> poses, loads, contacts;
  double time() const { return totals[0]; }
  Vec3 at(std::size_t body) const { return {poses[7 * body], poses[7 * body + 1], poses[7 * body + 2]}; }
};

Frame frame_from(const json& sizes, std::span<const unsigned char> bytes) {
  Frame frame;
  std::memcpy(frame.totals.data(), bytes.data(), sizeof frame.totals);
  const unsigned char* at = bytes.data() + sizeof frame.totals;
  for (const auto& [name, to] : {std::pair("poses", &frame.poses), {"loads", &frame.loads}, {"contacts", &frame.contacts}}) {
    to->resize(sizes[name].get<std::size_t>());
    if (!to->empty()) std::memcpy(to->data(), at, to->size() * sizeof(float));
    at += to->size() * sizeof(float);
  }
  CHECK(at == bytes.data() + bytes.size());
  return frame;
}

/// A page that keeps the messages that it receives. Its clock stands still, so that each frame is computed whole.
struct Page {
  explicit Page(const std::string& text = chain_text, bool floor = false) { load(text, floor); }

  PageHost host{[this](const std::string& text, std::span<const unsigned char> bytes) { receive(json::parse(text), bytes); },
                [this] { return clock += clock_step; }};
  PageSession session{host};
  double clock = 0, clock_step = 0;
  std::vector<json> posted{};
  std::vector<Frame> frames{};
  json topology{}, events = json::array();
  int topologies = 0;

  void receive(json message, std::span<const unsigned char> bytes) {
    if (const json& world = message["type"] == "loaded" ? message["world"] : message; world.contains("frame"))
      frames.push_back(frame_from(world["frame"], bytes));
    if (message["type"] == "loaded" && !message["world"].is_null()) topology = message["world"]["topology"];
    if (message["type"] == "topology") topology = message["topology"], ++topologies;
    if (message["type"] == "events") events.insert(events.end(), message["events"].begin(), message["events"].end());
    if (message["type"] == "rewound") events.erase(events.begin() + message["events"].get<int>(), events.end());
    posted.push_back(std::move(message));
  }
  void send(const json& message) {
    Message read(message.dump());
    session.obey(read);
  }
  void load(const std::string& text, bool floor = false) { send({{"type", "load"}, {"text", text}, {"floor", floor}}); }
  void act(const json& action) { send({{"type", "act"}, {"action", action}}); }
  void play(int ticks) {
    send({{"type", "play"}, {"on", true}});
    for (int i = 0; i < ticks; ++i) session.tick(1.0 / 60);
    send({{"type", "play"}, {"on", false}});
  }
  const Frame& last() const { return frames.back(); }
  int count(const std::string& type) const {
    return static_cast<int>(std::count_if(posted.begin(), posted.end(), [&](const json& each) { return each["type"] == type; }));
  }
  const json& last_of(const std::string& type) const {
    const auto found = std::find_if(posted.rbegin(), posted.rend(), [&](const json& each) { return each["type"] == type; });
    REQUIRE(found != posted.rend());
    return *found;
  }
  std::string refusal() const { return last_of("refused")["message"]; }
  json joint(const std::string& name) const {
    for (const json& each : topology["joints"])
      if (each["name"] == name) return each;
    return {};
  }
  std::vector<std::string> loops() const {
    std::vector<std::string> names;
    for (const json& each : topology["joints"])
      if (each.value("loop", false)) names.push_back(each["name"]);
    return names;
  }
};

std::string words(const json& diagnostics) {
  std::string all;
  for (const json& each : diagnostics) all += each["what"].get<std::string>() + " " + each["hint"].get<std::string>() + "\n";
  return all;
}

}  // namespace

TEST_CASE("page session: it keeps up with the clock, in whole steps, and reports events and topology") {
  Page page;
  page.play(60);
  CHECK(page.last().time() > 0.9);
  CHECK(page.last().time() < 1.02);
  CHECK(std::fabs(page.last().time() * 1000 - std::round(page.last().time() * 1000)) < 1e-9);
  REQUIRE(page.events.size() == 1);
  CHECK(page.events[0]["actions"] == json({"break chain/3"}));
  CHECK(page.topology["mechanisms"].size() == 2);
  CHECK(page.topologies == 1);
  // The energy balance closes: initial + work = final + dissipated + lost.
  const auto& t = page.last().totals;
  CHECK(t[9] + t[12] == doctest::Approx(t[10] + t[11] + t[13]).epsilon(1e-6));
}

TEST_CASE("page session: it is slower at a lower speed, and stands still while it does not play") {
  Page page;
  page.send({{"type", "speed"}, {"factor", 0.1}});
  page.play(60);
  CHECK(page.last().time() < 0.12);
  CHECK(page.frames.size() > 20);
  const std::size_t frames = page.frames.size();
  page.session.tick(1);
  CHECK(page.frames.size() == frames);
}

TEST_CASE("page session: rewinding leads to the same bits, and keeps the branch that was left") {
  Page page;
  page.play(12);
  const Frame at = page.last();
  page.play(30);
  const Frame end = page.last();
  page.send({{"type", "rewind"}, {"time", at.time()}});
  CHECK(page.last().totals == at.totals);
  CHECK(page.last().poses == at.poses);
  CHECK(page.events.empty());
  CHECK(page.topology["mechanisms"].size() == 1);
  const json rewound = page.last_of("rewound");
  CHECK(rewound["savedAs"] == 0);
  page.play(5);
  page.send({{"type", "branch"}, {"branch", 0}});
  CHECK(page.last().totals == end.totals);
  CHECK(page.last().poses == end.poses);
  CHECK(page.topology["mechanisms"].size() == 2);
  CHECK(page.last_of("resumed")["savedAs"] == 1);
  page.send({{"type", "branch"}, {"branch", 0}});  // it continues already
  CHECK(page.refusal() == "there is no branch 0");
  page.send({{"type", "branch"}, {"branch", 1}});
  CHECK(page.last().time() < end.time());
}

TEST_CASE("page session: an event that is undone does not happen again") {
  Page page;
  page.play(30);
  CHECK(page.events.size() == 1);
  page.send({{"type", "undo"}, {"event", 0}});
  CHECK(page.last().time() == doctest::Approx(0.3).epsilon(1e-12));
  page.play(30);
  CHECK(page.events.empty());
  CHECK(page.topology["mechanisms"].size() == 1);
  page.send({{"type", "undo"}, {"event", 3}});
  CHECK(page.refusal() == "there is no event 3");
}

TEST_CASE("page session: actions are those of scenarios, by name") {
  Page page;
  page.play(6);
  page.act({{"break", "chain/2"}});
  CHECK(page.topology["mechanisms"].size() == 2);
  CHECK(page.events[0]["actions"] == json({"break chain/2"}));
  page.act({{"lock", "chain/4"}});
  CHECK(page.joint("chain/4")["locked"] == 1);
  page.act({{"unlock", "chain/4"}});
  CHECK(page.joint("chain/4")["locked"] == 0);
  page.act({{"set", {{"joint", "chain/3"}, {"damping", 0.25}, {"stiffness", "2 N m"}}}});
  CHECK(page.joint("chain/3")["damping"] == 0.25);
  CHECK(page.joint("chain/3")["stiffness"] == 2);
  page.act({{"attach", {{"body", "chain/2"}, {"to", "chain/1"}, {"kind", "ball"}, {"name", "socket"}}}});
  CHECK(page.topology["mechanisms"].size() == 1);
  CHECK(page.count("refused") == 0);
  CHECK(page.joint("socket")["kind"] == "ball");
  page.act({{"free", "socket"}});
  page.act({{"weld", {{"body", "chain/2"}, {"to", "ground"}}}});
  CHECK(page.count("refused") == 0);
  const Vec3 before{page.last().totals[3], page.last().totals[4], page.last().totals[5]};
  page.act({{"break", "chain/*"}});  // all that are left, together
  CHECK(page.events.back()["actions"].size() > 1);
  CHECK(page.last().totals[3] == doctest::Approx(before.x));
  page.act({{"impulse", {{"body", "chain/4"}, {"force", {0, 0.5, 0}}}}});
  CHECK(page.last().totals[4] == doctest::Approx(before.y + 0.5));
  CHECK(page.count("refused") == 0);
}

TEST_CASE("page session: what can't be done is refused with the reason, and changes nothing") {
  Page page;
  const auto refused = [&page](const json& action) {
    const int before = page.count("refused");
    page.act(action);
    REQUIRE(page.count("refused") == before + 1);
    return page.refusal();
  };
  CHECK(refused({{"weld", {{"body", "chain/2"}, {"to", "chain/1"}}}}).find("weld") != std::string::npos);
  CHECK(refused({{"cut", "chain/2"}}).starts_with("unknown action 'cut'"));
  CHECK(refused({{"breaks", "chain/2"}}).find("did you mean 'break'?") != std::string::npos);
  CHECK(refused({{"break", "chain/9"}}).find("chain/9") != std::string::npos);
  CHECK(refused({{"break", "other/*"}}).find("no joint matches") != std::string::npos);
  CHECK(refused({{"break", 3}}).find("string") != std::string::npos);
  CHECK(refused({{"weld", {{"body", "chain/7"}}}}).find("there is no body 'chain/7'") != std::string::npos);
  CHECK(refused({{"set", {{"joint", "chain/2"}, {"damping", -1}}}}).find("damping") != std::string::npos);
  CHECK(refused(json::object()).find("an action is a table") != std::string::npos);
  CHECK(refused(nullptr).find("an action is a table") != std::string::npos);
  for (const json& message : std::vector<json>{{{"type", "stop"}},
                                               {{"type", 3}},
                                               {{"type", "play"}},
                                               {{"type", "speed"}, {"factor", 0}},
                                               {{"type", "gravity"}, {"value", {1, 2}}},
                                               {{"type", "grab"}, {"body", 1}, {"point", {0, 0, 0}}},
                                               {{"type", "grab"}, {"body", "x"}, {"point", {0, 0, 0}}},
                                               {{"type", "undo"}, {"event", -1}},
                                               {{"type", "strength"}, {"force", nullptr}}}) {
    const int before = page.count("refused");
    CAPTURE(message.dump());
    page.send(message);
    CHECK(page.count("refused") == before + 1);
  }
  CHECK(page.events.empty());
  CHECK(page.last().time() == 0);
  Page empty("format = 1\n");
  empty.act({{"break", "chain/2"}});
  CHECK(empty.refusal() == "load a scenario first");
}

TEST_CASE("page session: a weld closes a loop, breaking it opens the loop, and both can be undone") {
  Page page;
  page.play(6);
  page.act({{"weld", {{"body", "chain/3"}, {"to", "chain/1"}}}});
  REQUIRE(page.loops().size() == 1);
  const std::string weld = page.loops()[0];
  CHECK(page.joint(weld)["kind"] == "weld");
  CHECK(page.joint(weld)["row"] == 4);
  CHECK(page.topology["mechanisms"].size() == 1);
  CHECK(page.last().loads.size() == 6 * 5);
  const auto apart = [&page] { return norm(page.last().at(2) - page.last().at(0)); };
  const double distance = apart();
  page.play(6);
  CHECK(apart() == doctest::Approx(distance).epsilon(1e-5));
  page.act({{"break", weld}});
  CHECK(page.loops().empty());
  page.play(6);
  const Frame end = page.last();
  page.send({{"type", "undo"}, {"event", 1}});
  CHECK(page.loops().size() == 1);
  page.send({{"type", "undo"}, {"event", 0}});
  CHECK(page.loops().empty());
  page.send({{"type", "branch"}, {"branch", 0}});
  CHECK(page.last().poses == end.poses);
}

TEST_CASE("page session: scenarios with closed loops, with errors, and texts that are only checked") {
  const auto bars = [](const std::string& at) {
    return replaced(replaced(chain_text, "links = 4", "links = 3\nangle = \"40 deg\""), "break = ", "lock = ") +
           "[[loop]]\nname = \"pin\"\nkind = \"revolute\"\nbody = \"chain/3\"\nat = { xyz = " + at +
           " }\nchild_at = { xyz = [0.2, 0, 0] }\n";
  };
  Page page(bars("[0.3, 0, 0]"));
  CHECK(page.loops() == std::vector<std::string>{"pin"});
  page.play(12);
  const std::size_t frames = page.frames.size();
  page.send({{"type", "check"}, {"text", bars("[3, 0, 0]")}});
  CHECK(words(page.last_of("checked")["diagnostics"]).find("can't be closed") != std::string::npos);
  page.send({{"type", "check"}, {"text", replaced(chain_text, "links", "lynks")}});
  CHECK(page.last_of("checked")["diagnostics"][0]["line"] == 6);
  page.send({{"type", "check"}, {"text", chain_text}});
  CHECK(page.last_of("checked")["diagnostics"].empty());
  page.load("format = 1\n");
  CHECK(page.last_of("loaded")["world"].is_null());
  page.load("format = 1\nstate = \"s.json\"\n" + chain_text.substr(11));
  CHECK(page.last_of("loaded")["world"].is_null());
  CHECK(page.frames.size() == frames);
  page.play(6);
  CHECK(page.last().time() > 0.25);
}

TEST_CASE("page session: a crate that is grabbed and thrown lands on the floor and stays above it") {
  Page page(crates());
  const auto play_to = [&page](double time, const std::function<void(double)>& each) {
    page.send({{"type", "play"}, {"on", true}});
    for (int i = 0; page.last().time() < time && i < 5000; ++i) each(page.last().time()), page.session.tick(1.0 / 60);
  };
  const auto nothing = [](double) {};
  play_to(1.5, nothing);
  const std::string third = page.session.run().simulation().world().model()[{2}].name;
  page.send({{"type", "grab"}, {"body", third}, {"point", {0, 0, -0.3}}, {"target", {0, 0, 1.5}}});
  play_to(2, [&page](double time) { page.send({{"type", "pull"}, {"target", {3.6 * (time - 1.5), 0, 1.5}}}); });
  page.send({{"type", "release"}});
  play_to(5, nothing);
  CHECK(page.count("stopped") == 0);
  CHECK(page.count("refused") == 0);
  // The lowest corner of a crate, a cube of 40 cm around (0, 0, -0.3).
  const auto lowest = [](const Frame& frame, std::size_t body) {
    const float* const p = frame.poses.data() + 7 * body;
    const double w = p[3], x = p[4], y = p[5], z = p[6];
    const double row[] = {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
    return p[2] - 0.3 * row[2] - 0.2 * (std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2]));
  };
  for (const Frame& each : page.frames)
    for (const std::size_t body : {1u, 2u}) CHECK(lowest(each, body) > -1e-5);
  CHECK(lowest(page.last(), 2) < 0.05);
  CHECK(page.events.size() > 10);
  CHECK(page.topologies == 1);  // contacts change none: only the link that parted does
}

TEST_CASE("page session: a world that makes no progress is stopped, with a message") {
  Page page(chain_text + "[integrate]\nstep = 1e-9\n");
  REQUIRE(page.frames.size() == 1);
  page.clock_step = 0.02;  // each look at the clock takes longer than a frame may
  page.send({{"type", "play"}, {"on", true}});
  for (int i = 0; i < 60; ++i) page.session.tick(1.0 / 60);
  CHECK(page.count("stopped") == 0);
  for (int i = 0; i < 40; ++i) page.session.tick(1.0 / 60);
  REQUIRE(page.count("stopped") == 1);
  CHECK(page.last_of("stopped")["message"].get<std::string>().starts_with("No progress at t = "));
  CHECK(page.last_of("playing")["on"] == false);
}

TEST_CASE("page session: with a floor a chain that breaks and is thrown lands there, with its weight in the frames") {
  Page page(hanging_text, true);
  const json world = page.last_of("loaded")["world"];
  CHECK(world["scenario"]["floor"] == true);
  const double height = world["model"]["planes"][0]["point"][2];
  CHECK(height < -0.8);
  page.play(30);
  page.act({{"break", "chain/1"}});
  page.send({{"type", "grab"}, {"body", "chain/5"}, {"point", {0, 0, 0}}, {"target", {0, 0, 0.3}}});
  for (int i = 0; i < 30; ++i) page.send({{"type", "pull"}, {"target", {0.02 * i, 0, 0.3}}}), page.play(1);
  page.send({{"type", "release"}});
  page.play(240);
  CHECK(page.count("stopped") == 0);
  CHECK(page.count("refused") == 0);
  for (const Frame& each : page.frames)
    for (std::size_t body = 0; body < 8; ++body) CHECK(each.at(body).z > height - 0.002);
  for (std::size_t body = 0; body < 8; ++body) CHECK(page.last().at(body).z < height + 0.2);
  double force = 0;
  for (std::size_t c = 0; c < page.last().contacts.size(); c += 6) force += page.last().contacts[c + 5];
  CHECK(force == doctest::Approx(8 * 0.05 * 9.81).epsilon(0.1));
}

TEST_CASE("page session: a joint breaks when it is pulled harder than the limit") {
  Page page(hanging_text, true);
  page.send({{"type", "strength"}, {"force", 20}});
  page.play(60);
  CHECK(page.joint("chain/3")["force"] == 20);
  page.send({{"type", "grab"}, {"body", "chain/8"}, {"point", {0.1, 0, 0}}, {"target", {0, 0, -0.7}}});
  for (int i = 0; i < 60; ++i) page.send({{"type", "pull"}, {"target", {0.1 * i, 0, 0}}}), page.play(1);
  CHECK(std::any_of(page.events.begin(), page.events.end(),
                    [](const json& each) { return each["event"].get<std::string>().starts_with("strength of"); }));
  CHECK(page.topology["mechanisms"].size() > 1);
}

TEST_CASE("page run: a page that drives a run itself has snapshots, branches and numbers by message") {
  std::vector<json> posted;
  const PageHost host{[&posted](const std::string& text, auto) { posted.push_back(json::parse(text)); }, [] { return 0.0; }};
  PageRun run(host);
  const auto ask = [&posted](PageRun& to, const json& message) {
    posted.clear();
    Message read(message.dump());
    to.obey(read);
    return posted.empty() ? json() : posted[0];
  };
  CHECK(ask(run, {{"type", "topology"}})["message"] == "load a scenario first");
  CHECK(run.numbers(PageRun::Numbers::totals).empty());
  const json world = ask(run, {{"type", "load"}, {"text", chain_text}})["world"];
  CHECK(world["scenario"]["step"] == 1e-3);
  CHECK(world["kinds"]["revolute"]["q"] == json({"rad"}));
  CHECK(ask(run, {{"type", "run"}, {"time", 0.2}, {"budget", 1e6}}).is_null());
  const std::vector<double> at = run.numbers(PageRun::Numbers::motions);
  REQUIRE(at.size() == 4 * motion_size);
  CHECK(run.numbers(PageRun::Numbers::reactions).size() == 4 * joint_size);
  const json kept = ask(run, {{"type", "snapshot"}});
  const std::unique_ptr<PageRun> other = run.branch();
  CHECK(ask(run, {{"type", "act"}, {"action", {{"break", "chain/2"}}}}).is_null());
  CHECK(ask(run, {{"type", "topology"}})["topology"]["mechanisms"].size() == 2);
  CHECK(ask(run, {{"type", "events"}, {"first", 0}})["events"].size() == 1);
  CHECK(ask(run, {{"type", "run"}, {"time", 0.25}, {"budget", 1e6}}).is_null());
  CHECK(run.numbers(PageRun::Numbers::motions) != at);
  CHECK(ask(run, {{"type", "run"}, {"time", 1}, {"budget", 0}})["type"] == "interrupted");
  CHECK(ask(run, {{"type", "restore"}, {"snapshot", kept["snapshot"]}}).is_null());
  CHECK(run.numbers(PageRun::Numbers::motions) == at);
  CHECK(other->numbers(PageRun::Numbers::motions) == at);
  CHECK(ask(*other, {{"type", "topology"}})["topology"]["mechanisms"].size() == 1);
  CHECK(ask(run, {{"type", "drop"}, {"snapshot", kept["snapshot"]}}).is_null());
  CHECK(ask(*other, {{"type", "restore"}, {"snapshot", kept["snapshot"]}})["type"] == "refused");
  CHECK(ask(run, {{"type", "undo"}, {"event", 0}, {"again", false}})["type"] == "refused");
  CHECK(ask(run, {{"type", "pose"}, {"q", {1.0, 0, 0, 0}}}).is_null());
  CHECK(run.numbers(PageRun::Numbers::posed) == std::vector<double>{1, 0, 0, 0});
  CHECK(run.numbers(PageRun::Numbers::pose)[motion_size] == doctest::Approx(0.2 * std::cos(1)));
  CHECK(ask(run, {{"type", "pose"}, {"q", {1.0}}})["type"] == "refused");
}
