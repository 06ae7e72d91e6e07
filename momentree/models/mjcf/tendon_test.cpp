// Spatial tendons of MJCF files as springs.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

// A slider and a ball joint, with sites in both and in the world.
std::string arm(const std::string& tendons, const std::string& defaults = "") {
  return "<mujoco model='m'>" + defaults +
         "<worldbody><site name='top' pos='0 0 3'/><body name='a' pos='1 0 0'><geom size='0.1'/>"
         "<joint type='slide' axis='1 0 0' ref='0.5'/><site name='one' pos='0 0 1'/>"
         "<body name='b' pos='0 2 0'><geom size='0.1'/><joint name='x' axis='1 0 0'/><joint name='y' axis='0 1 0'/><site "
         "name='two' pos='0 1 0'/>"
         "<site fromto='0 0 0 2 0 0' name='three'/></body></body></worldbody>\n<tendon>" +
         tendons + "</tendon></mujoco>";
}
std::string spatial(const std::string& attributes, const std::string& from = "top", const std::string& to = "two") {
  return "<spatial " + attributes + "><site site='" + from + "'/><site site='" + to + "'/></spatial>";
}
std::string warnings(const std::string& tendon) {
  const ReadResult result = read_scenario_text(arm(tendon), "m.xml");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model.springs().empty());
  return said(result, Severity::warning);
}

}  // namespace

TEST_CASE("MJCF: a tendon between two sites is a spring, relaxed in the pose of the file") {
  const Model model =
      model_of(arm(spatial("name='t' stiffness='30' damping='2'") + spatial("stiffness='5'", "one", "three")), "m.xml");
  REQUIRE(model.springs().size() == 2);
  const Spring& t = model.springs()[0];
  CHECK(t.name == "m/t");
  CHECK(t.from == SpringEnd{ground, {0, 0, 3}});
  CHECK(t.to == SpringEnd{model.body("m/b"), {0, 1, 0}});
  CHECK(law_of(t) == SpringLaw{30, std::sqrt(1 + 9 + 9.0), 2, false, HUGE_VAL});
  const Spring& unnamed = model.springs()[1];
  CHECK(unnamed.name == "m/tendon2");
  CHECK(unnamed.to == SpringEnd{model.body("m/b"), {1, 0, 0}});
  CHECK(*unnamed.rest == doctest::Approx(std::sqrt(1 + 4 + 1.0)));
}

TEST_CASE("MJCF: a tendon that only has a longest length is a cable") {
  const Model model = model_of(arm(spatial("name='c' range='0 6' limited='true'")), "m.xml");
  REQUIRE(model.springs().size() == 1);
  CHECK(model.springs()[0].inextensible);
  CHECK(*model.springs()[0].rest == 6);
  CHECK(model_of(arm(spatial("name='s' range='0 6' stiffness='3'")), "m.xml").springs()[0].inextensible == false);
  CHECK(model_of(arm(spatial("name='s' range='0 6' limited='false'")), "m.xml").springs().empty());
}

TEST_CASE("MJCF: springlength, ropes, classes of tendons, and the mechanism's pose") {
  const Model model =
      model_of(arm(spatial("name='s' stiffness='30' springlength='0.7'") +
                       spatial("name='r' stiffness='30' springlength='0 2.5'") + spatial("name='c' class='strong'"),
                   "<default><tendon stiffness='3'/><default class='strong'><tendon stiffness='800'/></default></default>"),
               "m.xml");
  REQUIRE(model.springs().size() == 3);
  CHECK(*model.springs()[0].rest == 0.7);
  CHECK(law_of(model.springs()[1]) == SpringLaw{30, 2.5, 0, true, HUGE_VAL});
  CHECK(model.springs()[2].stiffness == 800);
  const ReadResult moved = read_scenario_text(arm(spatial("name='s' stiffness='30'")), "m.xml",
                                              {"mechanism.m.pose={xyz=[1,0,0],rpy=[0,0,\"90 deg\"]}"});
  REQUIRE(moved.scenario);
  const World world(moved.scenario->model);
  CHECK(norm(world.spring({0}).place_of_from - Vec3{1, 0, 3}) < 1e-14);
  CHECK(std::fabs(world.spring({0}).tension) < 1e-12);
  // What starts elsewhere is stretched: the rest length is that of the file.
  const ReadResult started =
      read_scenario_text(arm(spatial("name='s' stiffness='30'")), "m.xml", {"mechanism.m.joint.a.position=2"});
  REQUIRE(started.scenario);
  CHECK(*started.scenario->model.springs()[0].rest == doctest::Approx(std::sqrt(19.0)));
  CHECK(World(started.scenario->model).spring({0}).tension > 1);
  CHECK(read_scenario_text(to_toml(*moved.scenario, "").text, "s.toml").scenario->model.springs() ==
        moved.scenario->model.springs());
}

TEST_CASE("MJCF: tendons that are no springs are left out, by name and with the reason") {
  const std::string hint = "; only a straight tendon between two sites is a spring here";
  CHECK(warnings("<spatial name='t' stiffness='1'><site site='top'/><geom geom='g'/><site site='two'/></spatial>") ==
        "m.xml:2:59: warning: tendon 't' is left out: its path has a geom around which it wraps" + hint);
  CHECK(warnings("<spatial name='t' stiffness='1'><site site='top'/><site site='one'/><site site='two'/></spatial>") ==
        "m.xml:2:9: warning: tendon 't' is left out: its path has 3 sites" + hint);
  CHECK(warnings("<spatial name='t' stiffness='1'><site site='top'/><pulley divisor='2'/><site site='two'/></spatial>") ==
        "m.xml:2:59: warning: tendon 't' is left out: its path has a pulley" + hint);
  CHECK(warnings(spatial("name='t' stiffness='1' springlength='0.2 0.5'")) ==
        "m.xml:2:55: warning: tendon 't' is left out: there is no force between the two lengths of springlength; "
        "springlength=\"0 LENGTH\" is a rope, and one number a spring");
  CHECK(warnings(spatial("name='t' stiffness='1'", "two", "three")).find("same body") != std::string::npos);
  const ReadResult idle = read_scenario_text(arm(spatial("name='t' width='0.1'")), "m.xml");
  CHECK(said(idle, Severity::note).find("a tendon without stiffness and damping is left out") != std::string::npos);
  const ReadResult limited = read_scenario_text(arm(spatial("name='t' stiffness='1' range='0 1' frictionloss='2'")), "m.xml");
  CHECK(limited.scenario->model.springs().size() == 1);
  CHECK(said(limited, Severity::warning).find("tendon 't': range is ignored") != std::string::npos);
  CHECK(said(limited, Severity::warning).find("tendon 't': frictionloss is ignored") != std::string::npos);
}

TEST_CASE("MJCF: wrong tendons are errors") {
  CHECK(errors_of(arm(spatial("name='t' stiffness='1'", "top", "tow")), "m.xml") ==
        "m.xml:2:71: error: site: there is no site 'tow'; did you mean 'top'?");
  CHECK(errors_of(arm(spatial("name='t' stiffness='-1'")), "m.xml").find("stiffness: must not be negative") != std::string::npos);
  CHECK(errors_of(arm(spatial("name='t' stiffness='1'") + spatial("name='t' stiffness='1'")), "m.xml")
            .find("duplicate tendon 't'") != std::string::npos);
  CHECK(errors_of(arm("<spatial stiffness='1'><site/><site site='two'/></spatial>"), "m.xml").find("'site'") !=
        std::string::npos);
}
