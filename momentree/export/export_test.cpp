#include <momentree/export/export.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <tuple>

#include <momentree/export/drawing.hpp>
#include <momentree/export/exporter.hpp>
#include <momentree/export/mcap_file.hpp>
#include <momentree/export/solids.hpp>
#include <momentree/export/triangles.hpp>
#include <momentree/models/mesh/read_mesh.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/results.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/colour.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {
namespace {

using Corner = std::tuple<float, float, float>;

Vec3 point_of(const std::vector<float>& numbers, std::size_t i) {
  return {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
}

/// The volume that triangles enclose (divergence theorem); every edge must belong to two triangles that use it in opposite
/// directions, and every normal must point out of its triangles.
double volume_of(const Triangles& mesh) {
  std::map<std::pair<Corner, Corner>, int> edges;
  const auto corner = [&](std::uint32_t i) {  // −0 is 0
    return Corner{mesh.positions[3 * i] + 0.0f, mesh.positions[3 * i + 1] + 0.0f, mesh.positions[3 * i + 2] + 0.0f};
  };
  double volume = 0;
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const std::uint32_t i[3] = {mesh.indices[t], mesh.indices[t + 1], mesh.indices[t + 2]};
    const Vec3 a = point_of(mesh.positions, i[0]), b = point_of(mesh.positions, i[1]), c = point_of(mesh.positions, i[2]);
    volume += dot(a, cross(b, c)) / 6;
    const Vec3 across = normalized(cross(b - a, c - a));
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{corner(i[k]), corner(i[(k + 1) % 3])}], --edges[{corner(i[(k + 1) % 3]), corner(i[k])}];
      const Vec3 normal = point_of(mesh.normals, i[k]);
      CHECK(dot(normal, across) > 0.9);
      CHECK(norm(normal) == doctest::Approx(1).epsilon(1e-6));
    }
  }
  for (const auto& [edge, balance] : edges) CHECK(balance == 0);
  return volume;
}

TEST_CASE("triangles of solids are closed and have their volume, up to the flatness of the triangles") {
  const double pi = std::numbers::pi;
  CHECK(volume_of(unit_box()) == doctest::Approx(1).epsilon(1e-6));
  const double polygon = 24 * std::sin(2 * pi / 24) / (2 * pi);  // the area of 24 triangles in a circle
  CHECK(volume_of(unit_cylinder()) == doctest::Approx(polygon * pi / 4).epsilon(1e-6));
  CHECK(volume_of(unit_sphere()) < pi / 6);
  CHECK(volume_of(unit_sphere()) > 0.96 * pi / 6);
  const double ends = 8 * volume_of(unit_sphere()) * std::pow(0.3, 3);
  CHECK(volume_of(capsule_of(0.3, 2)) == doctest::Approx(ends + 2 * polygon * pi * 0.09).epsilon(1e-5));
}

TEST_CASE("turns from one direction to another, also to the opposite one") {
  for (const Vec3& to : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 2, -3}, Vec3{1e-9, 0, -1}, Vec3{-4, 0, 0}}) {
    const Vec3 turned = rotation_matrix(along_z(to)) * Vec3{0, 0, 1};
    CHECK(norm(turned - normalized(to)) < 1e-7);
  }
}

TEST_CASE("the checksum of MCAP files is CRC-32") {
  CHECK(crc32("123456789") == 0xcbf43926u);  // the check value of its definition
  CHECK(crc32("6789", crc32("12345")) == 0xcbf43926u);
  CHECK(crc32("") == 0);
}

TEST_CASE("colours are numbers") {
  CHECK(hex_colour("steelblue") == "#4682b4");
  CHECK(hex_colour("#12AbcD") == "#12AbcD");
  for (const char* wrong : {"", "#12345", "#1234567", "#12345g", "#-12345", "# 12345", "blau"}) CHECK(hex_colour(wrong).empty());
  CHECK(rgb_of("#ff8000").g == 128 / 255.0);
}

/// A run of two_mechanisms, a row every 10 ms, in which the arm comes off; the hand is a red box, the pendulum a sphere.
void write_export_input(const std::string& out, double until) {
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  simulation.at(0.1).then(break_joint("arm/shoulder"));
  std::vector<Shape> shapes(4);
  shapes[2] = Shape::of(contact::Box{{0.3, 0.2, 0.1}}), shapes[2].colour = "red";
  shapes[2].at = {{0.1, 0, 0}, from_rpy(0.1, 0.2, 0.3)};
  shapes[3] = Shape::of(contact::Sphere{0.25}, {0, 0, -1}), shapes[3].colour = "#008000";
  RunOrigin origin;
  origin.name = "arm";
  Recorder recorder(simulation, origin, model_json(simulation.world(), "an arm", shapes),
                    {.directory = out, .joints = joints_of(simulation, simulation.dry_run(), {})});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(until) == Status::ok);
  recorder.finish("done", {});
}

TEST_CASE("the solids of an exported run are in their places when another reader reads them") {
  const test::TemporaryFolder folder;
  write_export_input(folder / "r", 0.2);
  export_result(folder / "r", folder / "r.glb");
  const Drawing drawing = read_drawing(folder / "r");
  REQUIRE(drawing.times.size() == 21);
  const Mesh mesh = read_mesh_file(folder / "r.glb");  // at the first row; y of the file is z
  const auto points_in = [&mesh](const std::string& colour) {
    std::vector<Vec3> points;
    for (const MeshPart& part : mesh.parts)
      if (part.colour == colour) points.insert(points.end(), part.points.begin(), part.points.end());
    return points;
  };
  const Pose box{{0.1, 0, 0}, from_rpy(0.1, 0.2, 0.3)};
  const std::vector<Vec3> corners = points_in("#ff0000");
  REQUIRE(corners.size() == 24);  // of six faces
  for (const double x : {-0.15, 0.15})
    for (const double y : {-0.1, 0.1})
      for (const double z : {-0.05, 0.05}) {
        const Vec3 corner = drawing.place(0, 2, box * Vec3{x, y, z});
        CHECK(std::count_if(corners.begin(), corners.end(), [&](const Vec3& p) { return norm(p - corner) < 1e-6; }) == 3);
      }
  const Vec3 centre = drawing.place(0, 3, {0, 0, -1});
  const std::vector<Vec3> surface = points_in("#008000");
  REQUIRE(surface.size() > 100);
  for (const Vec3& p : surface) CHECK(norm(p - centre) == doctest::Approx(0.25).epsilon(1e-5));
}

/// The solids of a single body with these keys.
std::vector<Solid> solids_of_body(const std::string& keys) {
  const test::TemporaryFolder folder;
  const ReadResult read = read_scenario_text(
      "format = 1\n[[mechanism]]\nname = \"m\"\nroot = \"free\"\n[[mechanism.body]]\nname = \"a\"\n" + keys + "\n", "s.toml");
  INFO(rendered(read.diagnostics));
  REQUIRE(read.scenario);
  Simulation simulation(read.scenario->model, read.scenario->integration);
  Recorder recorder(simulation, {}, model_json(simulation.world(), "a body", read.scenario->shapes),
                    {.directory = folder / "r", .joints = joints_of(simulation, simulation.dry_run(), {})});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(0.01) == Status::ok);
  recorder.finish("done", {});
  const Drawing drawing = read_drawing(folder / "r");
  REQUIRE(drawing.solids.size() == 1);
  return drawing.solids[0];
}

TEST_CASE("an ellipsoid is drawn with its semi-axes, also from what is only its collision") {
  for (const char* const key : {"shape", "collision"}) {
    CAPTURE(key);
    const auto solids = solids_of_body("mass = 1\ninertia = 0.1\n" + std::string(key) +
                                       " = { ellipsoid = [0.3, 0.2, 0.1], at = { xyz = [1, 0, 0] } }");
    REQUIRE(!solids.empty());
    CHECK(solids.front().kind == Solid::Kind::ellipsoid);
    CHECK(norm(solids.front().size - Vec3{0.6, 0.4, 0.2}) < 1e-12);
    CHECK(norm(solids.front().at.position - Vec3{1, 0, 0}) < 1e-12);
  }
}

TEST_CASE("a body without shapes and joints is drawn as the ellipsoid of its inertia, one with joints as lines") {
  const auto solids = solids_of_body("mass = 2\ninertia = [0.3, 0.4, 0.5, 0.01, 0, 0]");
  REQUIRE(solids.size() == 1);
  CHECK(solids[0].kind == Solid::Kind::ellipsoid);
  const Vec3 half = 0.5 * solids[0].size;  // m (b² + c²) / 5 about each axis
  const Sym3 principal = diagonal(0.4 * (half.y * half.y + half.z * half.z), 0.4 * (half.x * half.x + half.z * half.z),
                                  0.4 * (half.x * half.x + half.y * half.y));
  const Sym3 inertia = rotate(rotation_matrix(solids[0].at.rotation), principal);
  for (const auto& [found, given] : {std::pair{inertia.xx, 0.3}, {inertia.yy, 0.4}, {inertia.zz, 0.5}, {inertia.xy, 0.01}})
    CHECK(found == doctest::Approx(given).epsilon(1e-9));
  const test::TemporaryFolder folder;
  write_export_input(folder / "r", 0.2);
  const Drawing drawing = read_drawing(folder / "r");
  for (const Solid& solid : drawing.solids[0]) CHECK(solid.kind != Solid::Kind::ellipsoid);
}

TEST_CASE("a drawing has the colours, solids and status of its run") {
  const test::TemporaryFolder folder;
  write_export_input(folder / "r", 0.2);
  const Drawing drawing = read_drawing(folder / "r");
  CHECK(drawing.status == "done");
  CHECK_FALSE(drawing.gap);
  REQUIRE(drawing.colourings.size() == 2);
  CHECK(drawing.colourings[0].from == 0);
  CHECK(drawing.colourings[1].from == doctest::Approx(0.1));
  CHECK(drawing.colourings[0].mechanism == std::vector<int>{0, 0, 0, 1});
  CHECK(drawing.colourings[1].mechanism == std::vector<int>{0, 2, 2, 1});
  CHECK(drawing.solids[3].front().kind == Solid::Kind::ellipsoid);
  CHECK(drawing.solids[3].front().size == Vec3{0.5, 0.5, 0.5});
}

TEST_CASE("USD: any name, one row, and the gap of a run that diverged") {
  const test::TemporaryFolder folder;
  write_export_input(folder / "r", 0.2);
  Drawing drawing = read_drawing(folder / "r");
  const auto has = [](const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; };
  CHECK(has(exporters::usd().bytes(drawing), "endTimeCode = 12\n"));
  CHECK(has(exporters::usd().bytes(drawing), "color3f inputs:diffuseColor.timeSamples"));  // of the arm that comes off

  drawing.run.bodies[0].name = "materials";
  drawing.run.bodies[1].name = "a \"b\\c\"\nd\xff";
  drawing.run.bodies[2].name = "a__b_c__d_";
  drawing.run.bodies[3].name = "";
  const std::string named = exporters::usd().bytes(drawing);
  CHECK(has(named, "def Xform \"materials_2\" (\n        displayName = \"materials\"\n"));
  CHECK(has(named, "def Xform \"a__b_c__d_\" (\n        displayName = \"a \\\"b\\\\c\\\" d\xef\xbf\xbd\"\n"));
  CHECK(has(named, "def Xform \"a__b_c__d__2\" (\n"));
  CHECK(has(named, "def Xform \"_\" (\n        displayName = \"\"\n"));

  drawing.gap = true;
  CHECK(has(exporters::usd().bytes(drawing), "            11.999999999999998: "));
  drawing.gap = false;
  drawing.times.resize(1), drawing.poses.resize(7 * drawing.run.bodies.size());
  const std::string still = exporters::usd().bytes(drawing);
  CHECK(has(still, "endTimeCode = 0\n"));
  CHECK_FALSE(has(still, "translate.timeSamples"));
  CHECK_FALSE(has(still, "orient.timeSamples"));
}

TEST_CASE("damaged results and wrong names are errors that name the file") {
  const test::TemporaryFolder folder;
  write_export_input(folder / "r", 0.05);
  const auto error_with = [&](const char* name, const std::string& text) {
    const std::string file = (folder / "r/") + name, before = is_there(file) ? read_text_file(file) : "";
    write_text_file(file, text);
    const std::string message = test::error_of([&] { export_result(folder / "r", folder / "o.glb"); });
    before.empty() ? static_cast<void>(std::filesystem::remove(file)) : write_text_file(file, before);
    return message;
  };
  const auto names = [](const std::string& message, const char* file, const char* problem) {
    return message.find(file) != std::string::npos && message.find(problem) != std::string::npos;
  };
  CHECK(names(error_with("model.json", "{\"gravity\": 1"), "model.json:1:", "error"));
  CHECK(names(error_with("summary.json", "{"), "summary.json:1", "error"));
  CHECK(names(error_with("meshes.json", "{\"format\": 1}"), "meshes.json", "meshes"));
  const std::string part = R"({"meshes": [{"parts": [{"low": [0,0,0], "high": [1,1,1], "points": "AAAAAAAA", "triangles": ")";
  CHECK(names(error_with("meshes.json", part + "AAAAAAEA\"}]}]}"), "meshes.json:1", "a point that does not exist"));
  CHECK(names(error_with("meshes.json", part + "AAA*\"}]}]}"), "meshes.json:1", "base64"));
  CHECK(error_with("meshes.json", part + "AAAAAAAA\"}]}]}").empty());
  CHECK(names(error_with("bodies.csv", "time,a.x\n"), "bodies.csv", "missing"));
  for (const char* name : {"o.gltf", "o", "o.glb.txt", ".glb"})
    CHECK(names(test::error_of([&] { export_result(folder / "r", folder / name); }), name, "error"));
  CHECK(names(test::error_of([&] { export_result(folder / "none", folder / "o.mcap"); }), "none", "no such directory"));
  CHECK(names(test::error_of([&] { export_result(folder / "r", folder / "none/o.mcap"); }), "none", "error"));
}

}  // namespace
}  // namespace momentree::io
