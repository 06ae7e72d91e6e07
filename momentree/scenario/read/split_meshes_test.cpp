// Meshes of scenarios and model files that are split into convex parts. mesh/split_test.cpp has the splitting itself, and
// python/tests/test_split.py what needs a library.
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <doctest/doctest.h>

#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/read/mesh_test_support.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;
using namespace momentree::io::test;

namespace {

// A mesh of two boxes, 0.2 m long, 1 m apart.
std::string two_boxes() {
  std::string two = box_mesh({0.1, 0.1, 0.1});
  for (int i = 0; i < 8; ++i)
    two += "v " + std::to_string((i & 1) != 0 ? 1.1 : 0.9) + " " + std::to_string((i & 2) != 0 ? 0.1 : -0.1) + " " +
           std::to_string((i & 4) != 0 ? 0.1 : -0.1) + "\n";
  return two + "f 17 19 20 18\nf 21 22 24 23\nf 17 18 22 21\nf 19 23 24 20\nf 17 21 23 19\nf 18 20 24 22\n";
}
// An L: it needs a library to be split.
const std::string an_angle =
    "v 0 0 0\nv 1 0 0\nv 1 .3 0\nv .3 .3 0\nv .3 1 0\nv 0 1 0\nv 0 0 .5\nv 1 0 .5\nv 1 .3 .5\nv .3 .3 .5\nv .3 1 .5\nv 0 1 .5\n"
    "f 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

}  // namespace

TEST_CASE("colliders: a mesh is split into parts of one body, which scenarios that are written keep") {
  test::TemporaryFolder folder;
  write(folder / "two.obj", two_boxes());
  const std::string mesh = "{ mesh = \"two.obj\", split = 0.05 }";
  const std::string ball =
      "[[mechanism]]\nname = \"b\"\nroot = \"free\"\npose = { xyz = [0.5, 0, 3] }\n[[mechanism.body]]\nname = \"b\"\nmass = 1\n"
      "inertia = 0.01\ncollision = { sphere = 0.1 }\n";
  const auto read = [&](const std::string& text) {
    write(folder / "s.toml", text);
    ReadResult result = read_scenario(folder / "s.toml");
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    CHECK(warnings(result) == "");
    return *result.scenario;
  };
  for (const std::string& touching :
       {"collision = " + mesh, "collision = [{ sphere = 0.1 }, " + mesh + "]", "shape = " + mesh + "\ncollision = \"shape\""}) {
    CAPTURE(touching);
    const Scenario scenario = read(a_floor + "collision = [" + mesh + ", { box = [1, 1, 1], at = { xyz = [9, 0, 0] } }]\n" +
                                   a_mesh_above + touching + "\n" + ball);
    const std::size_t of_body = touching.find("sphere") != std::string::npos ? 3 : 2;
    REQUIRE(scenario.model.colliders().size() == 4 + of_body + 1);
    for (const std::string& text :
         {to_toml(scenario.model, scenario.shapes, true, scenario.collision_shapes), to_toml(scenario, folder / ".").text}) {
      CAPTURE(text);
      const Scenario again = read(text);
      REQUIRE(again.model.colliders().size() == scenario.model.colliders().size());
      for (std::size_t i = 0; i < again.model.colliders().size(); ++i)
        CHECK(again.model.colliders()[i].solid == scenario.model.colliders()[i].solid);
    }
    CHECK(to_toml(scenario, folder / ".").diagnostics.empty());
    Simulation sim(scenario.model, {.step = 1e-2});
    REQUIRE(sim.run_until(1));
    CHECK(std::fabs(sim.world().motions()[1].pose.position.z - 0.1) < 1e-9);  // the ball falls in between, onto the floor
  }
}

TEST_CASE("colliders: meshes that cannot be split are errors with their places") {
  ::setenv("MOMENTREE_COACD", "/nowhere/lib_coacd.so", 1);
  test::TemporaryFolder folder;
  write(folder / "angle.obj", an_angle);
  write(folder / "open.obj", an_angle.substr(0, an_angle.rfind("f ")));
  const auto errors = [&](const std::string& collision) {
    write(folder / "s.toml", a_floor + a_mesh_above + "collision = " + collision + "\n");
    return said(read_scenario(folder / "s.toml"));
  };
  for (const char* wrong : {"0", "-1", "1.5", "0.001"})
    CHECK(errors("{ mesh = \"angle.obj\", split = " + std::string(wrong) + " }")
              .find("s.toml:12:43: error: split: must be from 0.01 to 1; 0.05 is usual") != std::string::npos);
  CHECK(errors("{ sphere = 1, split = 0.05 }").find("s.toml:12:35: error: split: only a mesh is split") != std::string::npos);
  CHECK(errors("{ mesh = \"open.obj\", split = 0.05 }")
            .find("s.toml:12:13: error: collision: the mesh 'open.obj' is not closed: its hull touches; close it") !=
        std::string::npos);
  CHECK(
      errors("{ mesh = \"angle.obj\", split = 0.05 }")
          .find("s.toml:12:13: error: collision: the mesh 'angle.obj' cannot be split without CoACD: /nowhere/lib_coacd.so: ") !=
      std::string::npos);
  write(folder / "s.toml", a_floor + a_mesh_above + "collision = { mesh = \"angle.obj\" }\n");
  CHECK(warnings(read_scenario(folder / "s.toml"))
            .find("is not convex: its hull touches, of which it fills 68 %; split = 0.05 divides it into convex parts") !=
        std::string::npos);
}

TEST_CASE("colliders: meshes of model files are split if the file or the mechanism asks for it") {
  ::setenv("MOMENTREE_COACD", "/nowhere/lib_coacd.so", 1);
  test::TemporaryFolder folder;
  write(folder / "two.obj", two_boxes());
  write(folder / "open.obj", an_angle.substr(0, an_angle.rfind("f ")));
  write(folder / "angle.obj", an_angle);
  const auto sdf = [&](const std::string& mesh, const std::string& attribute) {
    return "<sdf version='1.11'><model name='m'><link name='a'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1"
           "</izz></inertia></inertial><collision name='c'><geometry><mesh" +
           attribute + "><uri>" + mesh + "</uri></mesh></geometry></collision></link></model></sdf>";
  };
  const auto urdf = [&](const std::string& mesh) {
    return "<robot name='m'>\n" + link("a", collision("<mesh filename='" + mesh + "'/>")) + "</robot>\n";
  };
  const auto read = [&](const std::string& model, const std::string& split) {
    const std::string file = model.front() == '<' && model[1] == 's' ? "m.sdf" : "m.urdf";
    write(folder / file.c_str(), model);
    write(folder / "s.toml",
          a_floor + "[[mechanism]]\nname = \"m\"\nmodel = \"" + file + "\"\npose = { xyz = [0, 0, 2] }\n" + split + "\n");
    return read_scenario(folder / "s.toml");
  };
  const auto solids = [](const ReadResult& result) {
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return result.scenario->model.colliders().size() - 1;
  };
  const std::string decomposed = " optimization='convex_decomposition'";
  CHECK(solids(read(urdf("two.obj"), "")) == 1);
  CHECK(solids(read(urdf("two.obj"), "split = 0.05")) == 2);
  CHECK(solids(read(sdf("two.obj", ""), "")) == 1);
  CHECK(solids(read(sdf("two.obj", " optimization='convex_hull'"), "")) == 1);
  CHECK(solids(read(sdf("two.obj", decomposed), "")) == 2);
  CHECK(solids(read(sdf("two.obj", decomposed), "split = false")) == 1);
  CHECK(solids(read(sdf("angle.obj", decomposed), "split = false")) == 1);
  CHECK(warnings(read(urdf("open.obj"), "split = 0.05")).find("is not closed: its hull touches") != std::string::npos);
  const std::string missing = "s.toml:6:9: error: collision of 'm/a': the mesh 'angle.obj' cannot be split without CoACD: ";
  CHECK(said(read(sdf("angle.obj", decomposed), "")).find(missing) != std::string::npos);
  CHECK(said(read(urdf("angle.obj"), "split = 0.1")).find(missing) != std::string::npos);
  CHECK(said(read(urdf("angle.obj"), "split = true")).find("s.toml:8:9: error: split: ") != std::string::npos);
  CHECK(said(read(urdf("angle.obj"), "split = 2")).find("s.toml:8:9: error: split: must be from 0.01 to 1") != std::string::npos);
}
