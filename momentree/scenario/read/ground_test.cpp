// What the ground has besides its floor: planes and solids of scenarios and of model files.
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/results/model_json.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

const std::string wedge = "vertex='0 0 0 1 0 0 0 1 0 1 1 0 0 0 .5 0 1 .5' face='0 2 1 1 2 3 0 1 4 2 5 3 4 1 5 1 3 5 0 4 2 2 4 5'";

ReadResult read(const std::string& text, const std::string& file) {
  ReadResult result = read_scenario_text(text, file);
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return result;
}

std::string warnings(const ReadResult& result) {
  std::string text;
  for (const Diagnostic& each : result.diagnostics)
    if (each.severity == Severity::warning) text += each.message() + "\n";
  return text;
}

std::string errors(const std::string& text, const std::string& file = "s.toml") {
  return rendered(read_scenario_text(text, file).diagnostics);
}

std::vector<Collider> of_ground(const Model& model) {
  std::vector<Collider> all;
  for (const Collider& each : model.colliders())
    if (each.body == ground) all.push_back(each);
  return all;
}

// A solid that falls, and slides, rolls or comes to rest on what is below it.
std::string falling(const std::string& pose, const std::string& shape) {
  return "[[mechanism]]\nname = \"m\"\nroot = \"free\"\npose = { " + pose +
         " }\nstate = { velocity = { linear = [0.3, 0.1, 0] } }\n" +
         "[[mechanism.body]]\nname = \"m\"\nmass = 1\ninertia = [0.01, 0.012, 0.014]\ncollision = " + shape + "\n";
}

void check_same_motion(const std::string& one, const std::string& other, double until, double within) {
  const ReadResult a = read(one, "a.toml"), b = read(other, "b.toml");
  Simulation first(a.scenario->model, a.scenario->integration), second(b.scenario->model, b.scenario->integration);
  REQUIRE(first.run_until(until));
  REQUIRE(second.run_until(until));
  CHECK(first.events().size() == second.events().size());
  const Pose p = first.world().motions()[static_cast<std::size_t>(a.scenario->model.body("m/m").index)].pose,
             q = second.world().motions()[static_cast<std::size_t>(b.scenario->model.body("m/m").index)].pose;
  CHECK(norm(p.position - q.position) < within);
}

}  // namespace

TEST_CASE("ground: bodies move on its solids as on those of a fixed body, with both ways of contact") {
  const std::string begin = "format = 1\n[integrate]\nmethod = \"", rest = "\"\nuntil = 1\n";
  const std::string base = "[[mechanism]]\nname = \"base\"\n[[mechanism.body]]\nname = \"base\"\nmass = 1\ncollision = ";
  for (const std::string method : {"dop853", "stepping"})
    for (const std::string solid :
         {"{ box = [2, 2, 0.5], at = { rpy = [0.1, 0.2, 0] } }", "{ sphere = 0.6 }", "{ capsule = { radius = 0.3, length = 1 } }",
          "{ cylinder = { radius = 0.8, length = 0.4 } }", "{ ellipsoid = [0.9, 0.6, 0.3] }"}) {
      CAPTURE(method);
      CAPTURE(solid);
      const std::string ball = falling("xyz = [0.05, 0.02, 1.1]", "{ sphere = 0.1 }");
      check_same_motion(begin + method + rest + "[world]\ncollision = " + solid + "\n" + ball,
                        begin + method + rest + base + solid + "\n" + ball, 0.6, method == "stepping" ? 5e-3 : 1e-9);
    }
}

TEST_CASE("ground: geoms in the world of an MJCF file are placed with the mechanism, with their friction") {
  // A sphere that does not roll, on a plane tilted by 0.5 about y and turned with the mechanism, slides with g (sin a - mu cos
  // a).
  const std::string text =
      "<mujoco><worldbody><geom type='plane' size='1 1 1' euler='0 28.64788975654116 0' friction='0.2'/>"
      "<body name='m' pos='0.35958 0 0.65819'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>"
      "<geom size='0.5' friction='0.1'/></body></worldbody></mujoco>";
  test::TemporaryFolder folder;
  std::ofstream(folder / "m.xml") << text;
  std::ofstream(folder / "s.toml") << "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"m.xml\"\n"
                                      "pose = { xyz = [1, 2, 3], rpy = [0, 0, 0.7] }\n[integrate]\nmethod = \"dop853\"\n";
  const ReadResult result = read_scenario(folder / "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  REQUIRE(of_ground(model).size() == 1);
  const Collider plane = of_ground(model).front();
  const Vec3 normal{std::sin(0.5) * std::cos(0.7), std::sin(0.5) * std::sin(0.7), std::cos(0.5)};
  CHECK(plane.plane);
  CHECK(norm(plane.normal - normal) < 1e-12);
  CHECK(norm(plane.point - Vec3{1, 2, 3}) < 1e-12);
  CHECK(model.contact_law(model.body("m/m"), ground).friction == 0.2);  // the larger one, as in MuJoCo
  Simulation sim(model, result.scenario->integration);
  const auto speed = [&] { return norm(sim.world().motions()[static_cast<std::size_t>(model.body("m/m").index)].linear); };
  REQUIRE(sim.run_until(0.5));
  const double before = speed();
  REQUIRE(sim.run_until(1));
  CHECK(speed() - before == doctest::Approx(0.5 * 9.81 * (std::sin(0.5) - 0.2 * std::cos(0.5))).epsilon(1e-8));
}

TEST_CASE("ground: all geoms of the world of an MJCF file are there; what touches nothing is not") {
  const ReadResult result =
      read("<mujoco><asset><mesh name='w' " + wedge +
               "/></asset><worldbody><geom type='plane' size='1 1 1'/>"
               "<geom type='plane' size='1 1 1' pos='0 0 1e-12'/><geom type='plane' size='1 1 1' pos='0 7 0' euler='90 0 0'/>"
               "<geom type='box' size='1 1 1' pos='5 0 0'/><geom size='0.5' pos='8 0 0'/><geom type='capsule' size='0.1' "
               "fromto='0 0 0 0 0 1'/>"
               "<geom type='cylinder' size='1 1' pos='0 -5 0'/><geom type='ellipsoid' size='1 2 3' pos='0 9 0'/>"
               "<geom type='mesh' mesh='w' pos='0 0 -2'/><geom type='box' size='9 9 9' contype='0' conaffinity='0'/>"
               "<body name='wall'><geom type='plane' size='1 1 1' pos='-3 0 0' euler='0 90 0'/></body>"
               "<body name='m' pos='3 3 3'><freejoint/><geom size='0.1'/><geom type='plane' size='1 1 "
               "1'/></body></worldbody></mujoco>",
           "m.xml");
  const Model& model = result.scenario->model;
  const std::vector<Collider> all = of_ground(model);
  CHECK(all.size() == 9);  // two planes are one
  CHECK(std::count_if(all.begin(), all.end(), [](const Collider& each) { return each.plane; }) == 3);
  CHECK(warnings(result).find("1 collision element touches nothing, such as that of 'm/m': a plane of a body that moves") !=
        std::string::npos);
  const std::vector<GroundShape> drawn = ground_shapes(model);
  REQUIRE(drawn.size() == 6);
  CHECK(drawn.back().shape.kind == Shape::Kind::mesh);
  CHECK(drawn.back().mesh.points.size() == 6);
  const std::string json = model_json(World(model), "t", result.scenario->shapes);
  for (const char* const kind : {"box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"})
    CHECK(json.find("\"kind\": \"" + std::string(kind) + "\"", json.find("\"ground\"")) != std::string::npos);
}

TEST_CASE("ground: the floor of a scenario stays one plane where a file has one, and collision = \"none\" leaves it out") {
  test::TemporaryFolder folder;
  std::ofstream(folder / "m.xml") << "<mujoco><worldbody><geom type='plane' size='1 1 1' contype='2'/><body name='m' pos='0 0 1'>"
                                     "<freejoint/><geom size='0.1'/></body></worldbody></mujoco>";
  const auto planes = [&](const std::string& world, const std::string& mechanism) {
    std::ofstream(folder / "s.toml") << "format = 1\n" + world + "[[mechanism]]\nname = \"m\"\nmodel = \"m.xml\"\n" + mechanism;
    const ReadResult result = read_scenario(folder / "s.toml");
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return of_ground(result.scenario->model).size();
  };
  CHECK(planes("", "") == 1);
  CHECK(planes("[world]\nfloor = true\n", "") == 1);
  CHECK(planes("[world]\nfloor = { height = -1 }\n", "") == 2);
  CHECK(planes("", "collision = \"none\"\n") == 0);
}

TEST_CASE("ground: what a joint holds passes through the ground of its file that it reaches into, what is free must not") {
  const std::string plane = "<geom type='plane' size='1 1 1'/>";
  const auto with = [&](const std::string& joint) {
    return read_scenario_text("<mujoco><worldbody>" + plane + "<body name='m' pos='0 0 0.05'>" + joint +
                                  "<geom type='capsule' size='0.1 0.5'/></body></worldbody></mujoco>",
                              "m.xml");
  };
  const ReadResult held = with("<joint axis='0 1 0'/>");
  REQUIRE(held.scenario);
  CHECK(warnings(held).find("bodies of the model overlap at the start and pass through each other: 'm/m' and 'ground'") !=
        std::string::npos);
  const ReadResult loose = with("<freejoint/>");
  CHECK(!loose.scenario);
  CHECK(rendered(loose.diagnostics).find("'m/m' and 'ground' overlap by 0.55 m at the start") != std::string::npos);
}

TEST_CASE("ground: planes of static models of SDF, and of links that are fixed to the world") {
  const std::string inertial = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
  const auto plane = [](const std::string& normal, const std::string& pose, const std::string& mu) {
    return "<collision name='c'><pose>" + pose + "</pose><geometry><plane><normal>" + normal +
           "</normal><size>9 9</size></plane>" + "</geometry><surface><friction><ode><mu>" + mu + "</mu><mu2>" + mu +
           "</mu2></ode></friction></surface></collision>";
  };
  const ReadResult result = read(
      "<sdf version='1.9'><world name='w'><model name='flat'><static>true</static><pose>0 0 0.5 0 0 0</pose><link name='l'>" +
          inertial + plane("0 0 1", "0 0 -0.25 0 0 0", "0.6") +
          "</link></model><model name='m'><pose>0 0 5 0 0 0</pose><link name='base'>" + inertial +
          plane("1 0 0", "-1 0 0 0 0 0", "0.9") +
          "</link><joint name='j' type='fixed'><parent>world</parent><child>base</child></joint>" +
          "<link name='ball'><pose>3 0 0 0 0 0</pose>" + inertial +
          "<collision "
          "name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link></model></world></sdf>",
      "m.sdf");
  const std::vector<Collider> all = of_ground(result.scenario->model);
  REQUIRE(all.size() == 2);
  CHECK(norm(all[0].point - Vec3{0, 0, 0.25}) < 1e-12);
  CHECK(norm(all[0].normal - Vec3{0, 0, 1}) < 1e-12);
  CHECK(norm(all[1].point - Vec3{-1, 0, 5}) < 1e-12);
  CHECK(norm(all[1].normal - Vec3{1, 0, 0}) < 1e-12);
  CHECK(errors("<sdf version='1.9'><model name='m'><static>true</static><link name='l'>" + inertial +
                   plane("0 0 0", "0 0 0 0 0 0", "1") + "</link></model></sdf>",
               "m.sdf")
            .find("normal: must not be zero") != std::string::npos);
}

TEST_CASE("ground: planes and solids of a scenario are the same after they are written and read again") {
  const std::string text =
      "format = 1\n[world]\nfloor = { height = -2, friction = 0.3 }\ncollision = [{ plane = [1, 0, 2], at = { xyz = [-3, 0, 0] } "
      "}, "
      "{ box = [1, 2, 3], at = { xyz = [4, 0, 0], rpy = [0.1, 0, 0.3] } }, { sphere = 0.5 }, { cylinder = { radius = 0.2, length "
      "= 1 }, "
      "at = { xyz = [0, 4, 0] } }, { capsule = { radius = 0.2, length = 1 }, at = { xyz = [0, 6, 0] } }, { ellipsoid = [1, 2, "
      "3], "
      "at = { xyz = [0, 0, -9] } }]\n" +
      falling("xyz = [0, 0, 3]", "{ sphere = 0.1 }");
  const ReadResult result = read(text, "s.toml");
  const Model& model = result.scenario->model;
  CHECK(of_ground(model).size() == 7);
  const std::string written[] = {to_toml(model, {}, true), to_toml(*result.scenario, "").text};
  for (const std::string& each : written) {
    INFO(each);
    const ReadResult again = read(each, "again.toml");
    const std::vector<Collider> one = of_ground(model), other = of_ground(again.scenario->model);
    REQUIRE(one.size() == other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      CHECK(one[i].plane == other[i].plane);
      CHECK(norm(one[i].normal - other[i].normal) < 1e-15);
      CHECK(std::fabs(dot(one[i].normal, one[i].point - other[i].point)) < 1e-15);
      CHECK(norm(one[i].solid.centre - other[i].solid.centre) < 1e-15);
      CHECK(one[i].solid.vertices.size() == other[i].solid.vertices.size());
    }
    CHECK(again.scenario->model.contact_law(again.scenario->model.body("m/m"), ground).friction == 0.3);
  }
}

TEST_CASE("ground: mistakes in its shapes are errors that say what to write") {
  const std::string ball = falling("xyz = [0, 0, 3]", "{ sphere = 0.1 }"), begin = "format = 1\n[world]\ncollision = ";
  CHECK(errors(begin + "{ plane = [0, 0, 0] }\n" + ball).find("s.toml:3:23: error: plane: its normal must not be zero") !=
        std::string::npos);
  CHECK(errors(begin + "{ at = { xyz = [0, 0, 0] } }\n" + ball).find("a shape is one of plane, heightmap, box, sphere") !=
        std::string::npos);
  CHECK(errors(begin + "[]\n" + ball).find("collision: the list has no shape; leave it out") != std::string::npos);
  CHECK(errors(begin + "{ mesh = \"../w.stl\" }\n" + ball).find("is not a file in the scenario's folder") != std::string::npos);
  CHECK(errors(begin + "{ mesh = \"w.stl\" }\n" + ball).find("the mesh 'w.stl' cannot be read") != std::string::npos);
  CHECK(errors("format = 1\n" + falling("xyz = [0, 0, 3]", "{ plane = [0, 0, 1] }")).find("plane") != std::string::npos);
}
