// Which files a scenario and a model may name, and the errors for all others.
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

namespace fs = std::filesystem;

const std::string head = "format = 1\n[[mechanism]]\nname = \"m\"\n";
const std::string mjcf_body = "<body name='b'><freejoint/><geom size='1'/></body>";
const std::string arm = "<mujoco><worldbody>" + mjcf_body + "</worldbody></mujoco>";
const std::string fragment = "<mujocoinclude><worldbody>" + mjcf_body + "</worldbody></mujocoinclude>";

std::string robot(const std::string& mesh) {
  return "<robot name='r'><link name='l'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
         "</inertial><visual><geometry><mesh filename='" +
         mesh + "'/></geometry></visual></link></robot>";
}
std::string body(const std::string& mesh) {
  return head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\nshape = { mesh = \"" + mesh + "\" }\n";
}

class Folder {
 public:
  /// `here`: the scenario's or the model's folder; a sibling folder contains secrets.
  Folder() {
    write("beside/secret", "root:$6$secret:19000:0:99999:7:::\n");
    write("beside/b.xml", fragment);
    write("beside/b.sdf", "<sdf version='1.9'><model name='b'/></sdf>");
    write("here/meshes/a.stl", "");
  }
  void write(const std::string& name, const std::string& text) {
    const fs::path path(folder_ / name.c_str());
    fs::create_directories(path.parent_path());
    write_text_file(path.string(), text);
  }
  void link(const std::string& target, const std::string& name) { fs::create_symlink(target, folder_ / name.c_str()); }
  ReadResult read(const std::string& name) const { return read_scenario(folder_ / name.c_str()); }
  /// All messages, rendered, without the folder.
  std::string said(const std::string& name) const {
    std::string text = rendered(read(name).diagnostics);
    const std::string prefix = folder_ / "";
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) text.erase(at, prefix.size());
    return text;
  }
  std::string path(const char* name) const { return folder_ / name; }

 private:
  test::TemporaryFolder folder_;
};

bool has(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("a scenario names models and states anywhere") {
  Folder folder;
  folder.write("models/arm.xml", arm);
  folder.link("../models/arm.xml", "here/link.xml");
  for (const std::string& name : {std::string("../models/arm.xml"), std::string("link.xml"), folder.path("models/arm.xml")}) {
    folder.write("here/s.toml", head + "model = \"" + name + "\"\n");
    CHECK_MESSAGE(folder.read("here/s.toml").scenario, folder.said("here/s.toml"));
  }
}

TEST_CASE("a model of a folder above names files of its own folder, not of the scenario's") {
  Folder folder;
  folder.write("models/r.urdf", robot("meshes/b.stl"));
  folder.write("models/meshes/b.stl", "");
  folder.write("here/s.toml", head + "model = \"../models/r.urdf\"\n");
  CHECK(folder.said("here/s.toml") == "");
  folder.write("models/r.urdf", robot("../here/meshes/a.stl"));
  CHECK(has(folder.said("here/s.toml"), "note: a mesh is not in the model's folder or below it"));
}

TEST_CASE("symbolic links cannot lead a model out of its folder") {
  Folder folder;
  folder.link("../beside/b.xml", "here/b.xml");
  folder.link("../beside", "here/out");
  folder.link("meshes", "here/in");
  const std::string leads_out = " leads out of the model's folder through a symbolic link";
  for (const char* name : {"b.xml", "out/b.xml"}) {
    folder.write("here/m.xml", "<mujoco><include file='" + std::string(name) + "'/></mujoco>");
    CHECK(has(folder.said("here/m.xml"), ("error: include: '" + std::string(name) + "'" + leads_out).c_str()));
  }
  folder.write("here/m.xml", "<mujoco><include file='c.xml'/></mujoco>");
  folder.write("here/in/c.xml", fragment);
  folder.link("in/c.xml", "here/c.xml");
  CHECK_MESSAGE(folder.read("here/m.xml").scenario, folder.said("here/m.xml"));

  for (const char* name : {"out", "out/b.sdf"}) {
    folder.write("here/m.sdf",
                 "<sdf version='1.9'><model name='m'><include><uri>" + std::string(name) + "</uri></include></model></sdf>");
    CHECK(has(folder.said("here/m.sdf"), leads_out.c_str()));
  }
  for (const char* name : {"out/secret", "package://out/secret", "out/../beside/secret"}) {
    folder.write("here/r.urdf", robot(name));
    CHECK_MESSAGE(has(folder.said("here/r.urdf"), ("note: a mesh" + leads_out + ": pictures leave it out").c_str()),
                  folder.said("here/r.urdf"));
  }
  for (const char* name : {"in/a.stl", "package://meshes/a.stl", "package://robot/in/a.stl", "meshes/../in/a.stl"}) {
    folder.write("here/r.urdf", robot(name));
    CHECK_MESSAGE(folder.said("here/r.urdf") == "", folder.said("here/r.urdf"));
  }
}

TEST_CASE("a model that is itself a link may name files next to the link and next to its target") {
  Folder folder;
  folder.write("real/r.urdf", robot("meshes/b.stl"));
  folder.write("real/meshes/b.stl", "");
  folder.link("../real/r.urdf", "here/r.urdf");
  CHECK(has(folder.said("here/r.urdf"), "note: a mesh is not in the model's folder"));
  folder.link("../../real/meshes/b.stl", "here/meshes/b.stl");
  CHECK(folder.said("here/r.urdf") == "");
  folder.write("real/r.urdf", robot("meshes/a.stl"));
  CHECK(folder.said("here/r.urdf") == "");
}

TEST_CASE("a scenario's meshes are in its folder or below it, with symbolic links resolved") {
  Folder folder;
  folder.link("../beside", "here/out");
  const auto said_of = [&](const std::string& mesh) {
    folder.write("here/s.toml", body(mesh));
    return folder.said("here/s.toml");
  };
  CHECK(said_of("meshes/a.stl") == "");
  CHECK(said_of("meshes/../meshes/a.stl") == "");
  CHECK(has(said_of("out/secret"), "error: mesh: 'out/secret' leads out of the scenario's folder through a symbolic link"));
  CHECK(has(said_of("../beside/secret"), "error: mesh: '../beside/secret' is not a file in the scenario's folder or below it"));
  CHECK(has(said_of("/etc/passwd"), "error: mesh: '/etc/passwd' is not a file in the scenario's folder or below it"));
  CHECK(has(said_of("meshes"), "error: mesh: 'meshes' is a folder, not a mesh"));
  CHECK(has(said_of("none.stl"), "warning: mesh: there is no file 'none.stl': the body is drawn without it"));
  CHECK(has(said_of("a\\u001b.stl"), "error: mesh: 'a\\x1b.stl' is not a file in the scenario's folder or below it"));
}

TEST_CASE("a file that is not a model or state is not quoted, however it is named") {
  Folder folder;
  folder.write("beside/config.xml", "<config>\n<secret>x</secret\n</config>");
  folder.write("beside/sound.xml", "<!-- secret --><config>\n<secret>x</secret>\n</config>");
  folder.link("../beside/secret", "here/link.toml");
  folder.link("../beside/secret", "here/link.urdf");
  const auto tell = [&](const std::string& name) {
    const std::string text = folder.said(name);
    CAPTURE(text);
    CHECK(!text.empty());
    CHECK(!has(text, "$6$"));
    CHECK(!has(text, "root"));
    CHECK(!has(text, "<secret>"));
    return text;
  };
  tell("beside/secret");
  tell("here/link.toml");
  CHECK(has(tell("here/link.urdf"), "here/link.urdf:1:"));
  tell("beside/config.xml");
  CHECK(has(tell("beside/sound.xml"), "error: no model begins with '<config>'"));
  for (const char* name : {"../beside/secret", "../beside/config.xml", "../beside/sound.xml", "link.toml"}) {
    folder.write("here/s.toml", head + "model = \"" + name + "\"\n");
    tell("here/s.toml");
  }
  folder.write("here/secret.xml", "root:$6$secret:19000:0:99999:7:::\n");
  folder.write("here/m.xml", "<mujoco><include file='secret.xml'/></mujoco>");
  CHECK(has(folder.said("here/m.xml"), "here/secret.xml:1:"));
  CHECK(!has(folder.said("here/m.xml"), "$6$"));

  Model model;
  model.add({.name = "m/a", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  for (const char* text : {"root:$6$secret:19000::\n", "{ \"secret\": \"$6$\" }", "{ \"auths\": { \"secret\": 1 } }",
                           "\"secret\"", "[\"secret\"]"}) {
    const std::string message = test::error_of([&] { read_state(text, "s.json", model, ""); });
    CAPTURE(message);
    CHECK(message.starts_with("s.json:1:"));
    CHECK(!has(message, "secret"));
    CHECK(!has(message, "$6$"));
  }
}

TEST_CASE("a broken model is quoted from its first tag on") {
  Folder folder;
  for (const char* text : {"<robot name='r>", "<?xml version='1.0'?>\n<!-- <x> -->\n<robot\n name='r'><link",
                           "\xEF\xBB\xBF<sdf><", "<mujoco>&amp <"}) {
    CAPTURE(text);
    folder.write("r.xml", text);
    CHECK(has(folder.said("r.xml"), " | "));
  }
}
