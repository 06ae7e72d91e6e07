// Files that include others: names, poses, copies, folder limits and cycles.
#include <filesystem>

#include <doctest/doctest.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

std::string a_link(const std::string& name, const std::string& more = "") {
  return "<link name='" + name + "'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>" +
         more + "</link>\n";
}
std::string sdf(const std::string& inside, const std::string& more = "") {
  return "<sdf version='1.9'>\n<model name='m'" + more + ">\n" + inside + "\n</model>\n</sdf>";
}
std::string include(const std::string& uri, const std::string& more = "") {
  return "<include><uri>" + uri + "</uri>" + more + "</include>\n";
}
Vec3 start_of(const Model& model, const std::string& body) {
  const BodySpec& spec = model[model.body("m/" + body)];
  REQUIRE(spec.joint.kind == Kind::free);
  return {spec.q[0], spec.q[1], spec.q[2]};
}

class Folder {
 public:
  void write(const char* name, const std::string& text) {
    const std::filesystem::path path(folder_ / name);
    std::filesystem::create_directories(path.parent_path());
    write_text_file(path.string(), text);
  }
  ReadResult read() const { return read_scenario(folder_ / "m.sdf"); }
  Model model() const {
    const ReadResult result = read();
    CAPTURE(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return result.scenario->model;
  }
  /// The errors, without the folder.
  std::string errors() const {
    std::string text = said(read(), Severity::error);
    const std::string prefix = folder_ / "";
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) text.erase(at, prefix.size());
    return text;
  }

 private:
  test::TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("SDF: one file may be included several times, each time with its own name and pose") {
  Folder folder;
  folder.write("wheel.sdf", "<sdf version='1.5'><model name='wheel'><pose>5 0 0 0 0 0</pose>" +
                                a_link("hub", "<pose>0 0 1 0 0 0</pose>") + "</model></sdf>");
  folder.write("m.sdf", sdf(include("wheel.sdf") + include("model://wheel.sdf", "<name>left</name><pose>0 1 0 0 0 0</pose>") +
                            include("wheel.sdf",
                                    "<name>right</name><pose>0 1 0 0 0 0</pose>"
                                    "<placement_frame>hub</placement_frame>") +
                            include("wheel.sdf", "<name>post</name><static>1</static>")));
  const Model model = folder.model();
  CHECK(model.size() == 4);
  CHECK(start_of(model, "wheel::hub") == Vec3{5, 0, 1});
  CHECK(start_of(model, "left::hub") == Vec3{0, 1, 1});
  CHECK(start_of(model, "right::hub") == Vec3{0, 1, 0});
  CHECK(model[model.body("m/post::hub")].joint.kind == Kind::weld);
}

TEST_CASE("SDF: a merged model's parts are the including model's own") {
  Folder folder;
  folder.write("arm.sdf", "<sdf version='1.9'><model name='arm'>" + a_link("a") +
                              a_link("b", "<pose relative_to='__model__'>0 0 1 0 0 0</pose>") +
                              "<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz "
                              "expressed_in='__model__'>1 0 0</xyz></axis></joint></model></sdf>");
  folder.write("m.sdf", sdf("<include merge='true'><uri>arm.sdf</uri><pose>1 0 0 0 0 1.5707963267948966</pose></include>" +
                            a_link("c", "<pose relative_to='b'/>") +
                            "<joint name='k' type='fixed'><parent>b</parent><child>c</child></joint>"));
  const Model model = folder.model();
  REQUIRE(model.size() == 3);
  CHECK(start_of(model, "a") == Vec3{1, 0, 0});
  CHECK(model[model.joint("m/j")].at.position == Vec3{0, 0, 1});
  CHECK(norm(model[model.joint("m/j")].joint.axis - Vec3{1, 0, 0}) < 1e-15);  // in the arm's frame, which was rotated with it
  CHECK(model[model[model.joint("m/k")].parent].name == "m/b");
  folder.write("m.sdf", sdf("<include merge='true'><uri>arm.sdf</uri></include>" + a_link("a")));
  CHECK(folder.errors() == "arm.sdf:1:50: error: duplicate link 'a': the name is already used by another on line 3 of 'm.sdf'");
}

TEST_CASE("SDF: files are named relative to the including file or to the model's folder; folders by their model") {
  Folder folder;
  const auto model = [](const std::string& inside) { return "<sdf version='1.9'><model name='n'>" + inside + "</model></sdf>"; };
  folder.write("m.sdf", sdf(include("parts/arm.sdf") + include("model://hand")));
  folder.write("parts/arm.sdf",
               model(a_link("a") + include("tip.sdf", "<name>t</name>") + include("../tip.sdf", "<name>u</name>")));
  folder.write("parts/tip.sdf", model(a_link("near")));
  folder.write("tip.sdf", model(a_link("far")));
  folder.write("hand/model.config",
               "<model><name>hand</name><sdf version='1.4'>old.sdf</sdf><sdf version='1.9'>new.sdf</sdf></model>");
  folder.write("hand/new.sdf", "<sdf version='1.9'><model name='hand'>" + a_link("palm") + "</model></sdf>");
  const Model all = folder.model();
  CHECK(all.size() == 4);
  CHECK(all.has_body("m/n::t::near"));
  CHECK(all.has_body("m/n::u::far"));
  CHECK(all.has_body("m/hand::palm"));
}

TEST_CASE("SDF: impossible includes are refused with their places") {
  Folder folder;
  const auto errors = [&](const std::string& inside) {
    folder.write("m.sdf", sdf(inside));
    return folder.errors();
  };
  CHECK(errors(include("none.sdf")) == "m.sdf:3:15: error: include: 'none.sdf': there is no such file");
  CHECK(errors(include("../secret.sdf")) ==
        "m.sdf:3:15: error: include: '../secret.sdf' is not in the model's folder or below it; copy it there");
  CHECK(errors(include("file:///etc/passwd")) ==
        "m.sdf:3:15: error: include: '/etc/passwd' is not in the model's folder or below it; copy it there");
  CHECK(errors(include("https://fuel.gazebosim.org/1.0/x")) ==
        "m.sdf:3:15: error: include: 'https://fuel.gazebosim.org/1.0/x' is not fetched; copy it into the model's folder and name "
        "it "
        "there");
  CHECK(errors(include("")) == "m.sdf:3:10: error: include: the name of a file is missing");
  CHECK(errors("<include/>") == "m.sdf:3:1: error: <include> has no <uri>; for example <uri>arm.sdf</uri>");
  CHECK(errors(include("m.sdf")) ==
        "m.sdf:3:15: error: include: files include each other in a cycle: 'm.sdf' – 'm.sdf'; leave one of them out");
  folder.write("a.sdf", sdf(include("b.sdf")));
  folder.write("b.sdf", sdf(include("a.sdf")));
  CHECK(errors(include("a.sdf")) ==
        "b.sdf:3:15: error: include: files include each other in a cycle: 'a.sdf' – 'b.sdf' – 'a.sdf'; leave one of them out");
  folder.write("robot.urdf", "<robot name='r'/>");
  CHECK(errors(include("robot.urdf")) ==
        "robot.urdf:1:1: error: an SDF can include only SDF, not '<robot>'; convert it (gz sdf -p)");
  folder.write("a.sdf", "<sdf version='1.9'>\n" + a_link("x") + "</sdf>");
  CHECK(errors(include("a.sdf")) ==
        "a.sdf:1:1: error: the included file has no <model>; for example <model name=\"arm\">, with its links");
  folder.write("a.sdf", sdf("<link name='a'><inertial><mass>x</mass></inertial></link>"));
  CHECK(errors(include("a.sdf") + include("a.sdf", "<name>n</name>")) == "a.sdf:3:32: error: mass: 'x' is not a number");
  folder.write("a.sdf", sdf(a_link("a")));
  CHECK(errors(include("a.sdf") + include("a.sdf")) ==
        "m.sdf:4:1: error: duplicate include 'm': the name is already used by another on line 3");
  CHECK(errors(include("a.sdf", "<placement_frame>a</placement_frame>")) ==
        "m.sdf:3:43: error: <placement_frame> has no effect without <pose>; give a <pose>");
  // A model read from text cannot name files.
  CHECK(errors_of(sdf(include("a.sdf")), "m.sdf") ==
        "m.sdf:3:15: error: include: a model read from text cannot name files; read it from its file");
}

TEST_CASE("SDF: files that double each other are stopped at a limit, at no cost") {
  Folder folder;
  for (int k = 0; k < 40; ++k) {
    const std::string next = "f" + std::to_string(k + 1) + ".sdf";
    folder.write(k == 0 ? "m.sdf" : ("f" + std::to_string(k) + ".sdf").c_str(),
                 sdf(include(next, "<name>a</name>") + include(next, "<name>b</name>")));
  }
  folder.write("f40.sdf", sdf(a_link("a")));
  const std::string errors = folder.errors();
  CHECK(errors.find(
            "more than 1000000 links or 100000 models, with those of included files; do files include each other repeatedly?") !=
        std::string::npos);
}
