#include <momentree/results/recording/recording.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/export/picture/frame_svg.hpp>
#include <momentree/export/picture/labels.hpp>
#include <momentree/export/picture/scene.hpp>
#include <momentree/export/picture/svg.hpp>
#include <momentree/results/recording/body_table.hpp>

namespace momentree::io {
namespace {

/// A result directory that is removed when the test ends.
class Directory {
 public:
  Directory() {
    std::random_device random;  // tests may run in parallel
    path_ = std::filesystem::temp_directory_path() /
            ("momentree-picture-" + std::to_string(random()) + "-" + std::to_string(random()));
    std::filesystem::create_directories(path_);
  }
  ~Directory() { std::filesystem::remove_all(path_); }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  const std::filesystem::path& path() const { return path_; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path_ / name, std::ios::binary) << text; }

 private:
  std::filesystem::path path_;
};

const std::string header_of_two =
    "time,a/1.x,a/1.y,a/1.z,a/1.qw,a/1.qx,a/1.qy,a/1.qz,a/2.x,a/2.y,a/2.z,a/2.qw,a/2.qx,a/2.qy,a/2.qz\n";

std::string row(double time, double x) { return std::to_string(time) + ",0,0,0,1,0,0,0," + std::to_string(x) + ",0,0,1,0,0,0\n"; }

const std::string joints_of_two = R"({
  "a/1": {"kind": "revolute", "parent": null, "child": "a/1",
    "at": {"xyz": [0, 0, 0], "quat": [1, 0, 0, 0]}, "child_at": {"xyz": [0, 0, 0], "quat": [1, 0, 0, 0]}},
  "a/pin": {"kind": "revolute", "parent": "a/1", "child": "a/2",
    "at": {"xyz": [1, 0, 0], "quat": [1, 0, 0, 0]}, "child_at": {"xyz": [0, 0, 0], "quat": [1, 0, 0, 0]}}})";

std::string model_of_two(const std::string& title) {
  return R"({"format": 1, "title": ")" + title + R"(", "gravity": [0, -9.81, 0],
    "mechanisms": [{"name": "a", "root": "a/1", "bodies": ["a/1", "a/2"]}],
    "bodies": {"a/1": {"extent": [[[0, 0, 0], [1, 0, 0]]], "shape": null},
               "a/2": {"extent": [[[0, 0, 0], [1, 0, 0]]], "shape": null}},
    "joints": )" +
         joints_of_two + "}";
}

/// A line of events.jsonl; `topology`: its members.
std::string event(double time, const std::string& changes, const std::string& topology = "") {
  return R"({"time":)" + std::to_string(time) + R"(,"event":"#1","actions":[],"changes":[)" + changes + "]" +
         (topology.empty() ? "" : R"(,"topology":{)" + topology + "}") + "}\n";
}
std::string joint(const std::string& name, const std::string& kind, const std::string& parent, const std::string& child) {
  return '"' + name + R"(":{"kind":")" + kind + R"(","parent":)" + (parent.empty() ? "null" : '"' + parent + '"') +
         R"(,"child":")" + child +
         R"(","at":{"xyz":[1,2,3],"quat":[1,0,0,0]},"child_at":{"xyz":[0,0,0],"quat":[1,0,0,0]},"locked":false})";
}
const std::string break_of_pin =
    R"("gone":["a/pin"],"joints":{)" + joint("a/2", "free", "", "a/2") + R"(},"moved":{"a/2":[[1,1]]})";

/// The message of the Error that reading the directory throws; empty if it throws none.
std::string complaint(const Directory& directory) {
  try {
    read_recording(directory.path());
  } catch (const Error& error) {
    return error.message();
  }
  return {};
}

bool mentions(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a break makes the separated part a separate mechanism, from the event on") {
  Directory directory;
  std::string table = header_of_two;
  for (int k = 0; k <= 10; ++k)
    table += row(0.1 * k, 1 + 0.1 * k) + (k == 5 ? row(0.5, 7) : "");  // two rows at the event: before and after
  directory.write("bodies.csv", table);
  directory.write("model.json", model_of_two("Two"));
  directory.write(
      "events.jsonl",
      R"({"time":0.5,"event":"#1","actions":["break a/pin"],"changes":[{"kind":"break","joint":"a/pin"}],"topology":{)" +
          break_of_pin + "}}\n" + event(0.8, R"({"kind":"break","joint":"a/pin","skipped":"it is gone"})"));
  const Recording run = read_recording(directory.path(), 0.1);
  REQUIRE(run.frames.size() == 11);
  CHECK(run.frames[5].poses[1].position.x == 7);  // the row after the event
  CHECK(run.mechanisms == std::vector<std::string>{"a", "a/2"});
  CHECK(run.phase_at(0.4).mechanism == std::vector<int>{0, 0});
  CHECK(run.phase_at(0.5).mechanism == std::vector<int>{0, 1});
  CHECK(run.phase_at(0.9).mechanism == std::vector<int>{0, 1});
  CHECK(run.events[0].broken == std::vector<int>{1});
  CHECK(run.events[1].broken.empty());

  const std::string svg = draw_svg(run);
  CHECK(mentions(svg, "a/2, from 0.5 s"));
  CHECK(mentions(svg, "0.5 s: break a/pin"));
  CHECK(!mentions(svg, "script"));
}

TEST_CASE("a mechanism whose root joint breaks keeps its name, also where the joint has the name of its body") {
  Directory directory;
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, 2));
  directory.write("model.json", model_of_two("Two"));
  directory.write("events.jsonl", event(0.5, R"({"kind":"break","joint":"a/1"})",
                                        R"("gone":[],"joints":{)" + joint("a/1", "free", "", "a/1") + R"(},"moved":{})"));
  const Recording run = read_recording(directory.path());
  CHECK(run.mechanisms == std::vector<std::string>{"a"});
  CHECK(run.events[0].broken == std::vector<int>{0});
}

TEST_CASE("bodies are joined and separated as the events define") {
  Directory directory;
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, 2));
  directory.write("model.json", model_of_two("Two"));
  directory.write(
      "events.jsonl",
      event(0.1, R"({"kind":"break","joint":"a/pin"})", break_of_pin) +
          event(0.2, R"({"kind":"weld","joint":"grasp","body":"a/1","to":"a/2"},{"kind":"hit","joint":"a/1"})",
                R"("gone":["a/2"],"joints":{)" + joint("grasp", "weld", "a/2", "a/1") + R"(},"moved":{"a":[[1,1]]})") +
          event(0.3, R"({"kind":"break","joint":"grasp"})",
                R"("gone":["grasp"],"joints":{)" + joint("a/2", "free", "", "a/2") + R"(},"moved":{"a/2":[[1,1]]})") +
          event(0.4, R"({"kind":"attach","joint":"held","body":"a/2","to":"ground"})",
                R"("gone":["a/2"],"joints":{)" + joint("held", "ball", "", "a/2") + R"(},"moved":{})"));
  const Recording run = read_recording(directory.path());
  CHECK(run.mechanisms == std::vector<std::string>{"a", "a/2"});
  CHECK(run.phase_at(0.15).mechanism == std::vector<int>{0, 1});
  CHECK(run.phase_at(0.25).mechanism == std::vector<int>{0, 0});
  CHECK(run.phase_at(0.35).mechanism == std::vector<int>{0, 1});
  CHECK(run.phase_at(0.45).mechanism == std::vector<int>{0, 1});
  CHECK(run.phase_at(0.45).joined == std::vector<char>{1, 0});
  CHECK(run.events[1].impacts == 1);
  CHECK(run.events[2].broken.empty());
}

TEST_CASE("bodies that do not exist cannot move to another mechanism") {
  for (const char* range : {"[1,2]", "[-1,1]", "[0]", "[0,1e9]"}) {
    Directory directory;
    directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, 2));
    directory.write("model.json", model_of_two("Two"));
    directory.write("events.jsonl", event(0.5, "", R"("gone":[],"joints":{},"moved":{"a":[)" + std::string(range) + "]}"));
    CHECK(mentions(complaint(directory), "events.jsonl:1"));
  }
}

TEST_CASE("a joint that closes a loop is drawn while it exists, and is not the inboard joint of its child") {
  const auto loop = [](const std::string& name, const std::string& kind, const std::string& parent, const std::string& child) {
    std::string text = joint(name, kind, parent, child);
    return text.insert(text.size() - 1, R"(,"loop":true)");
  };
  Directory directory;
  std::string table = header_of_two;
  for (int k = 0; k <= 8; ++k) table += row(0.1 * k, 1);
  directory.write("bodies.csv", table);
  std::string model = model_of_two("Two");
  model.insert(model.rfind("}}"), "," + loop("pin", "ball", "", "a/2"));
  directory.write("model.json", model);
  directory.write(
      "events.jsonl",
      event(0.1, R"({"kind":"break","joint":"pin"})", R"("gone":["pin"],"joints":{},"moved":{})") +
          event(0.2, R"({"kind":"attach","joint":"clasp","body":"a/1","to":"a/2"})",
                R"("gone":[],"joints":{)" + loop("clasp", "revolute", "a/2", "a/1") + R"(},"moved":{})") +
          event(0.3, R"({"kind":"break","joint":"a/pin"})",  // the clasp takes its place in the tree
                R"("gone":["a/pin"],"joints":{)" + joint("clasp", "revolute", "a/2", "a/1") + R"(},"moved":{})") +
          event(0.4, R"({"kind":"break","joint":"clasp"})", R"("gone":["clasp"],"joints":{},"moved":{"a/2":[[1,1]]})"));
  const Recording run = read_recording(directory.path(), 0.1);
  CHECK(run.bodies[1].joint == "a/pin");
  REQUIRE(run.loops.size() == 2);
  CHECK(run.loops[0].name == "pin");
  CHECK(run.loops[0].at_start);
  CHECK(run.loops[1].parent == 1);
  CHECK(run.loops[1].child == 0);
  CHECK(!run.loops[1].at_start);
  const auto loops_at = [&run](double time) { return run.phase_at(time).loops; };
  CHECK(loops_at(0.05) == std::vector<int>{0});
  CHECK(loops_at(0.15).empty());
  CHECK(loops_at(0.25) == std::vector<int>{1});
  CHECK(loops_at(0.35) == std::vector<int>{1});
  CHECK(loops_at(0.45).empty());
  CHECK(run.mechanisms == std::vector<std::string>{"a", "a/2"});
  CHECK(run.phase_at(0.35).mechanism == std::vector<int>{0, 0});  // held together by what was a loop
  CHECK(run.phase_at(0.35).joined == std::vector<char>{1, 0});
  CHECK(run.events[0].opened == std::vector<int>{0});
  CHECK(run.events[0].broken.empty());
  CHECK(run.events[1].opened.empty());
  CHECK(run.events[2].broken == std::vector<int>{1});
  CHECK(run.events[2].opened.empty());
  CHECK(run.events[3].opened == std::vector<int>{1});

  const Scene scene = build_scene(run, choose_view(drawn_points(run), run.gravity));
  const auto joints_at = [&scene](std::size_t frame) { return scene.frames[frame].joints.size(); };
  CHECK(joints_at(0) == 1);  // that to the ground is an anchor
  CHECK(scene.anchors.size() == 2);
  CHECK(joints_at(2) == 2);
  CHECK(joints_at(3) == 1);
  CHECK(joints_at(5) == 0);
  // Lines from its bodies to the one that was made in the run, while it is there.
  const auto lines_at = [&scene](std::size_t frame) { return scene.frames[frame].primitives.size(); };
  CHECK(lines_at(1) == 2);
  CHECK(lines_at(2) == 3);
  CHECK(lines_at(5) == 2);
  CHECK(scene.events[0].places.size() == 1);
  CHECK(mentions(draw_svg(run), "0.3 s: "));
}

TEST_CASE("poses alone are enough for a picture") {
  Directory directory;
  // an interrupted run: the last row is truncated
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(0.2, 2) + "0.4,0,0");
  const Recording run = read_recording(directory.path());
  CHECK(run.frames.size() == 2);
  CHECK(run.mechanisms == std::vector<std::string>{"a"});
  CHECK(run.title == directory.path().filename().string());
  CHECK(mentions(draw_svg(run), "<circle"));
  directory.write("final.json", R"({"mechanisms":[{"name":"a","bodies":["a/1","a/2"]}],"joints":)" + joints_of_two + "}");
  CHECK(read_recording(directory.path()).bodies[0].extent.size() == 1);
}

TEST_CASE("all shapes of a body are drawn, each in its colour") {
  Directory directory;
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, 2));
  std::string model = model_of_two("Two");
  const std::string at = R"("at": {"xyz": [0, 0, 0], "quat": [1, 0, 0, 0]})";
  const std::string shapes = R"("shape": {"kind": "mesh", "file": "a.stl", "colour": "#aaaa01", )" + at +
                             R"(}, "more_shapes": [{"kind": "box", "size": [0.2, 0.2, 0.2], "colour": "#aaaa02", )" + at +
                             R"(}, {"kind": "sphere", "radius": 5, "colour": "gold", )" + at + "}]";
  const std::string none = R"("shape": null)";
  directory.write("model.json", model.replace(model.find(none), none.size(), shapes));
  const Recording run = read_recording(directory.path());
  REQUIRE(run.bodies[0].shape.more.size() == 2);
  const std::string svg = draw_svg(run);
  CHECK(!mentions(svg, "#aaaa01"));  // meshes are not drawn
  CHECK(mentions(svg, "#aaaa02"));
  CHECK(mentions(svg, "gold"));
}

TEST_CASE("the floor is drawn where it is, and impacts of bodies are counted") {
  Directory directory;
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, 2));
  std::string model = model_of_two("Two");
  const std::size_t end = model.rfind('}');
  directory.write("model.json", model.insert(end, R"(, "planes": [{"point": [5, -2, 3], "normal": [0, 2, 0]}])"));
  const auto contact = [](double time, const std::string& name) {
    std::string line = event(time, "");
    return line.replace(line.find("#1"), 2, name).insert(1, R"("bodies":["a/2","ground"],)");
  };
  directory.write("events.jsonl",
                  contact(0.5, "impact") + contact(0.6, "impact grip") + contact(0.7, "rest") + contact(0.8, "slip grip"));
  const Recording run = read_recording(directory.path());
  REQUIRE(run.planes.size() == 1);
  const Scene scene = build_scene(run, view_along({0, 0, -1}, run.gravity));
  REQUIRE(scene.planes.size() == 1);
  for (const Point2& corner : scene.planes[0]) CHECK(corner.y == doctest::Approx(2));  // edge on; y is down
  CHECK(scene.bounds.low.x <= 0);
  CHECK(scene.contacts == 2);
  CHECK(scene.events.empty());
  CHECK(mentions(draw_svg(run), "2 impacts of bodies"));
  directory.write("model.json", model.replace(model.find("[0, 2, 0]"), 9, "[0, 0, 0]"));
  CHECK(mentions(complaint(directory), "normal: it is zero"));
}

TEST_CASE("a title cannot break the picture") {
  Directory directory;
  directory.write("bodies.csv", header_of_two + row(0, 1));
  directory.write("model.json", model_of_two("<script>alert('1')</script>"));
  const std::string svg = draw_svg(read_recording(directory.path()));
  CHECK(mentions(svg, "<title>&lt;script&gt;alert(&apos;1&apos;)&lt;/script&gt;</title>"));
  CHECK(!mentions(svg, "<script"));
}

TEST_CASE("errors in the files are reported with their places") {
  Directory directory;
  CHECK(mentions(complaint(directory), "bodies.csv"));
  directory.write("bodies.csv", "");
  CHECK(mentions(complaint(directory), "the file is empty"));
  directory.write("bodies.csv", "t,a.x\n");
  CHECK(mentions(complaint(directory), "not 'time'"));
  directory.write("bodies.csv", "time,a.x,a.y,a.z,a.qw,a.qx,a.qy\n0,0,0,0,1,0,0\n");
  CHECK(mentions(complaint(directory), "bodies.csv:1: error: the column 'a.qz' is missing"));
  directory.write("bodies.csv", "time,a.x,a.x\n");
  CHECK(mentions(complaint(directory), "twice"));
  directory.write("bodies.csv", "time,a.mass\n");
  CHECK(mentions(complaint(directory), "not part of a pose"));
  directory.write("bodies.csv", header_of_two);
  CHECK(mentions(complaint(directory), "no complete row"));
  directory.write("bodies.csv", header_of_two + row(0, 1) + "1,2,3\n" + row(2, 1));
  CHECK(mentions(complaint(directory), "bodies.csv:3: error: the row has 3 of 15 columns"));
  directory.write("bodies.csv", header_of_two + row(0, 1) + row(1, NAN));
  CHECK(mentions(complaint(directory), "bodies.csv:3: error: column 'a/2.x' is nan, not a finite number"));
  directory.write("bodies.csv", header_of_two + "0,zero,0,0,1,0,0,0,0,0,0,1,0,0,0\n");
  CHECK(mentions(complaint(directory), "column 'a/1.x': 'zero' is not a number"));
  directory.write("bodies.csv", header_of_two + row(1, 1) + row(0, 1));
  CHECK(mentions(complaint(directory), "time runs backwards"));
  directory.write("bodies.csv", header_of_two + row(0, 1));
  directory.write("events.jsonl", "{\"time\": 1\n{}\n");
  CHECK(mentions(complaint(directory), "events.jsonl:1: error: the line is not JSON"));
  directory.write("events.jsonl", "{\"time\": \"soon\"}\n");
  CHECK(mentions(complaint(directory), "events.jsonl:1"));
  directory.write("events.jsonl", "");
  directory.write("model.json", "{");
  CHECK(mentions(complaint(directory), "model.json:1:1: error: this is not JSON"));
  directory.write("model.json", "{\"gravity\": [0, 1e999, 0]}");
  CHECK(mentions(complaint(directory), "model.json:1:"));
  directory.write("model.json", "{}");
  CHECK(mentions(complaint(directory), "model.json:1:1: error: the model has no 'gravity'"));
}

TEST_CASE("fields of CSV may be quoted") {
  CHECK(split_csv("a,\"b,c\",\"d \"\"e\"\"\",") == std::vector<std::string>{"a", "b,c", "d \"e\"", ""});
}

TEST_CASE("by default there is a frame every 0.2 s, unless these are too few or too many") {
  Directory directory;
  const auto frames = [&](double until, double output) {
    std::string table = header_of_two;
    for (int k = 0; k * output <= until * (1 + 1e-12); ++k) table += row(k * output, 1);
    directory.write("bodies.csv", table);
    return read_recording(directory.path());
  };
  CHECK(frames(3, 0.02).frames.size() == 16);
  CHECK(frames(3, 0.02).every == 0.2);
  CHECK(frames(0.1, 0.001).every == 0.005);
  CHECK(frames(100, 0.5).every == 5);
  CHECK(frames(0, 1).frames.size() == 1);
  CHECK_THROWS_AS(read_recording(directory.path(), -1), Error);
}

TEST_CASE("labels cover neither each other nor leave the picture") {
  LabelPlacer placer({0, 0, 200, 100});
  std::vector<Rect> taken;
  for (int k = 0; k < 60; ++k)
    if (const auto box = placer.place({100, 50}, {1, 0}, 30, 14)) {
      for (const Rect& other : taken) CHECK(!box->meets(other));
      CHECK(box->x >= 0);
      CHECK(box->y + box->height <= 100);
      taken.push_back(*box);
    }
  CHECK(taken.size() > 3);
  CHECK(taken.size() < 60);
  CHECK(taken.front().x > 100);  // on the requested side
}

TEST_CASE("the convex hull keeps only the corners") {
  CHECK(convex_hull({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0.5, 0}, {0, 0}}).size() == 4);
  CHECK(convex_hull({{1, 1}, {1, 1}}).size() == 1);
}

}  // namespace momentree::io
