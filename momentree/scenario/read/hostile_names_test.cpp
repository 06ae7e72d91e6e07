// Names with terminal commands or deceptive characters are refused in every format; names in every language are accepted.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

std::string toml(const std::string& name) {
  return "format = 1\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"" + name + "\"\nmass = 1\ninertia = 1\n";
}
std::string urdf(const std::string& name) {
  return "<robot name='r'><link name='" + name +
         "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>";
}
std::string sdf(const std::string& name) {
  return "<sdf version='1.9'><model name='m'><link name='" + name +
         "'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link></model></sdf>";
}
std::string mjcf(const std::string& name) {
  return "<mujoco><worldbody><body name='" + name + "'><freejoint/><geom size='1'/></body></worldbody></mujoco>";
}

struct Format {
  const char* file;
  std::string (*text)(const std::string& name);
};
const std::vector<Format> formats = {{"s.toml", toml}, {"r.urdf", urdf}, {"m.sdf", sdf}, {"m.mjcf", mjcf}};

}  // namespace

TEST_CASE("a name with an invisible character is refused, and shown as an escape") {
  for (const auto& [name, shown] : {std::pair{"a\xC2\x9B", "'a\\u009b'"},
                                    {"a\xC2\x85 b", "'a\\u0085 b'"},
                                    {"\xE2\x80\xAE\xE2\x80\xA6", "'\\u202e…'"},
                                    {"a\xE2\x80\xA8", "'a\\u2028'"},
                                    {"a\xE2\x80\x8Bz", "'a\\u200bz'"},
                                    {"a\xEF\xBB\xBFz", "'a\\ufeffz'"}})
    for (const Format& format : formats) {
      CAPTURE(format.file);
      CAPTURE(name);
      const std::string errors = errors_of(format.text(name), format.file);
      CHECK(errors.find(std::string("cannot be named ") + shown + ": it has an invisible character") != std::string::npos);
      CHECK(errors.find("error: name:") != std::string::npos);
    }
}

TEST_CASE("names of every language, and their spaces, are names") {
  for (const char* name : {"left arm", "Öl pumpe", "関節 1", "مفصل", "рука", "🦾", "👩‍🔧", "a\xC2\xA0z"})
    for (const Format& format : formats) {
      CAPTURE(format.file);
      CHECK(model_of(format.text(name), format.file)[{0}].name.ends_with(name));
    }
}

TEST_CASE("a title of a model is shown as escapes") {
  const auto result = read_scenario_text("<robot name='a\xE2\x80\xAEz'>" + urdf("l").substr(16), "r.urdf");
  REQUIRE(result.scenario);
  CHECK(result.scenario->title == "a\\u202ez");
}

TEST_CASE("a model's file may have any name, a mechanism not") {
  for (const char* file : {"a\x1b[31m.urdf", "a\xFF.urdf", "\xE2\x80\xAE.urdf", "a\nb.urdf"}) {
    const auto result = read_scenario_text(urdf("l"), file);
    REQUIRE(result.scenario);
    CHECK(first_invisible(result.scenario->model[{0}].name) == std::string::npos);
  }
}

TEST_CASE("Model::add refuses the same names as the reader") {
  Model model;
  for (const char* name : {"a\x1b", "a\xFF", "a\xE2\x80\xAE"})
    CHECK(test::error_of([&] {
            model.add({.name = name, .mass = 1, .inertia = diagonal(1)});
          }).ends_with("error: name: must be UTF-8 without control characters and other invisible characters"));
}

TEST_CASE("names that occur only in a state document must follow the same rule") {
  Model model;
  model.add({.name = "m/a", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  const auto read = [&](const std::string& joint, const std::string& mechanism) {
    const std::string text = "{\"joints\": {\"" + joint +
                             "\": {\"kind\": \"free\", \"child\": \"m/a\", \"parent\": null, \"q\": [0,0,0,1,0,0,0], \"v\": "
                             "[0,0,0,0,0,0]}}, \"mechanisms\": [{\"name\": \"" +
                             mechanism + "\", \"bodies\": [\"m/a\"]}]}";
    return test::error_of([&] { read_state(text, "s.json", model, ""); });
  };
  CHECK(read("new", "left part") == "");
  CHECK(read("n\\u001b", "part").find("a joint cannot be named 'n\\x1b'") != std::string::npos);
  CHECK(read("new", "\\u202epart").find("a mechanism cannot be named '\\u202epart'") != std::string::npos);
  CHECK(read("new", "").find("a mechanism cannot be named ''") != std::string::npos);
}
