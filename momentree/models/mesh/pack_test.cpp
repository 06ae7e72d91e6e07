// Meshes from scenarios and model files to the documents of pages.
#include <momentree/models/mesh/pack.hpp>

#include <cmath>
#include <filesystem>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/models/mesh/test_meshes.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/session.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

namespace momentree::io {
namespace {

using namespace test;
namespace fs = std::filesystem;

class MeshFolder {
 public:
  void write(const std::string& name, const std::string& text) const {
    const fs::path path(folder_ / name.c_str());
    fs::create_directories(path.parent_path());
    write_text_file(path.string(), text);
  }
  Scenario read(const std::string& name) const {
    ReadResult result = read_scenario(folder_ / name.c_str());
    CAPTURE(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    notes = models::said(result, Severity::note);
    return std::move(*result.scenario);
  }
  std::string operator/(const char* name) const { return folder_ / name; }
  mutable std::string notes;

 private:
  TemporaryFolder folder_;
};

std::vector<std::uint16_t> shorts(const nlohmann::json& text) {
  const std::string bytes = from_base64(text.get<std::string>()).value();
  std::vector<std::uint16_t> numbers(bytes.size() / 2);
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

/// The triangles of a packed part, as a page unpacks it.
std::vector<Corners> unpacked(const nlohmann::json& part) {
  const std::vector<std::uint16_t> points = shorts(part.at("points")), triangles = shorts(part.at("triangles"));
  const auto at = [&](std::size_t p) {
    double x[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const double low = part.at("low").at(k), high = part.at("high").at(k);
      x[k] = low + (high - low) * points.at(3 * p + k) / 65535;
    }
    return Vec3{x[0], x[1], x[2]};
  };
  std::vector<Corners> all;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    all.push_back({at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])});
  return all;
}

/// A tetrahedron.
MeshPart tetrahedron(double size = 1) {
  MeshPart part;
  part.points = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
  part.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return part;
}

nlohmann::json document_of(const Scenario& scenario) {
  const Session session(scenario);
  return nlohmann::json::parse(model_json(session.simulation().world(), "", scenario.shapes));
}

const std::string inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";
std::string robot_with(const std::string& visuals) {
  return "<robot name='r'>\n<link name='l'>" + inertial + visuals + "</link></robot>";
}
std::string visual(const std::string& file, const std::string& material = "") {
  return "<visual><geometry><mesh filename='" + file + "'/></geometry>" + material + "</visual>";
}

TEST_CASE("packed positions are within half a step of those in the file") {
  std::mt19937 random(3);
  const MeshFolder folder;
  for (int i = 0; i < 30; ++i) {
    MeshPart part = random_part(random, 40, 60);
    std::erase_if(part.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[0] == t[2]; });
    folder.write("a.stl", binary_stl(part));
    auto source = std::make_shared<MeshSource>();
    source->path = folder / "a.stl";
    const PackedMeshes packed = pack_meshes({source});
    CHECK(packed.warnings.empty());
    const nlohmann::json mesh = nlohmann::json::parse(packed.json).at(0);
    CHECK(mesh.at("triangles") == part.triangles.size());
    const std::vector<Corners> found = unpacked(mesh.at("parts").at(0)), expected = corners_of(part);
    REQUIRE(found.size() <= expected.size());  // without those with the same corners as another
    std::size_t e = 0;
    for (const Corners& t : found) {
      const auto near = [&](const Corners& other) {
        return norm(t[0] - other[0]) + norm(t[1] - other[1]) + norm(t[2] - other[2]) < 3 * 1.5 * 16.0 / 65535;
      };
      while (e < expected.size() && !near(expected[e])) ++e;
      CHECK(e < expected.size());
    }
  }
}

TEST_CASE("all meshes together keep to the limit; small ones stay whole") {
  const auto ball = [](int n) {
    auto source = std::make_shared<MeshSource>();
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < n; ++j) {
        const double a = 3.14159265 * i / n, b = 2 * 3.14159265 * j / n;
        source->inside.points.push_back({std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
      }
    const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * n + j % n); };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        source->inside.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        source->inside.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
      }
    source->place.line = n;
    return std::shared_ptr<const MeshSource>(source);
  };
  const PackedMeshes packed = pack_meshes({ball(60), ball(10), ball(80)}, 4000);
  std::size_t sum = 0;
  std::vector<std::size_t> sizes;
  for (const nlohmann::json& mesh : nlohmann::json::parse(packed.json)) {
    sizes.push_back(unpacked(mesh.at("parts").at(0)).size());
    sum += sizes.back();
  }
  CHECK(sizes[1] >= 180);
  CHECK(sum <= 4000);
  CHECK(sum > 3950);
}

TEST_CASE("meshes of a URDF: their numbers, their colours, and what is said of those that cannot be drawn") {
  const MeshFolder folder;
  folder.write("meshes/a.stl", text_stl(tetrahedron()));
  folder.write("meshes/b.obj", obj(tetrahedron(), "blue"));
  folder.write("meshes/m.mtl", "newmtl blue\nKd 0 0 1\n");
  folder.write("meshes/broken.stl", "solid x\nvertex 1 2 x\n");
  const std::string red = "<material name='red'><color rgba='1 0 0 1'/></material>";
  folder.write("r.urdf",
               robot_with(visual("meshes/a.stl", red) + visual("package://r/meshes/b.obj", red) + visual("meshes/a.stl") +
                          visual("meshes/a.stl", red) + "\n" + visual("meshes/broken.stl") + visual("none.stl")));
  const Scenario scenario = folder.read("r.urdf");
  const nlohmann::json body = document_of(scenario).at("bodies").at("r/l");
  CHECK(body.at("shape").at("mesh") == 0);
  CHECK(!body.at("shape").contains("colour"));
  CHECK(body.at("more_shapes").at(0).at("mesh") == 1);
  CHECK(body.at("more_shapes").at(1).at("mesh") == 2);  // without a colour
  CHECK(body.at("more_shapes").at(2).at("mesh") == 0);
  CHECK(body.at("more_shapes").at(3).at("mesh") == 3);
  CHECK(!body.at("more_shapes").at(4).contains("mesh"));
  CHECK(folder.notes.find("a mesh is not in the model's folder") != std::string::npos);

  const PackedMeshes packed = meshes_json(mesh_sources(scenario.shapes));
  const nlohmann::json meshes = nlohmann::json::parse(packed.json).at("meshes");
  REQUIRE(meshes.size() == 4);
  CHECK(meshes.at(0).at("parts").at(0).at("colour") == "#ff0000");
  CHECK(meshes.at(1).at("parts").at(0).at("colour") == "#0000ff");  // of the mesh
  CHECK(!meshes.at(2).at("parts").at(0).contains("colour"));
  CHECK(meshes.at(3).is_null());
  REQUIRE(packed.warnings.size() == 1);
  CHECK(packed.warnings[0].message() == (folder / "r.urdf") + ":3:35: warning: the mesh '" + (folder / "meshes/broken.stl") +
                                            "' is not drawn: a coordinate is not a number; the motion does not depend on it");
}

TEST_CASE("a mesh of the package that contains the model is found, and nothing else above the model") {
  const MeshFolder folder;
  folder.write("pkg/meshes/a.stl", text_stl(tetrahedron()));
  folder.write("pkg/secret.txt", "x");
  folder.write("other/a.stl", text_stl(tetrahedron()));
  const auto has_source = [&](const std::string& file) {
    folder.write("pkg/urdf/r.urdf", robot_with(visual(file)));
    return folder.read("pkg/urdf/r.urdf").shapes.front().source != nullptr;
  };
  CHECK(!has_source("package://pkg/meshes/a.stl"));  // the folder is not marked as a package
  folder.write("pkg/package.xml", "");
  CHECK(has_source("package://pkg/meshes/a.stl"));
  CHECK(folder.read("pkg/urdf/r.urdf").shapes.front().mesh == "../meshes/a.stl");
  CHECK(has_source("package:///pkg/meshes/a.stl"));
  CHECK(pack_meshes(mesh_sources(folder.read("pkg/urdf/r.urdf").shapes)).warnings.empty());
  CHECK(!has_source("package://pkg/secret.txt"));
  CHECK(!has_source("package://other/a.stl"));
  CHECK(!has_source("package://urdf/../meshes/a.stl"));
  fs::create_symlink("../../other/a.stl", folder / "pkg/meshes/out.stl");
  CHECK(!has_source("package://pkg/meshes/out.stl"));
}

TEST_CASE("MJCF: meshdir, scale, refpos and refquat place the vertices where MuJoCo has them") {
  const MeshFolder folder;
  folder.write("assets/a.stl", text_stl(tetrahedron()));
  const std::string q = "0.8 0 0.6 0";
  folder.write(
      "m.xml",
      "<mujoco><compiler meshdir='assets'/><asset><mesh file='a.stl' scale='2 2 2' refpos='1 2 3' refquat='" + q +
          "'/><mesh name='in' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3'/></asset><worldbody><body name='b'>"
          "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><geom type='mesh' mesh='a' pos='0 0 1' quat='0 1 0 0' "
          "rgba='0 1 0 1'/><geom type='mesh' mesh='in'/><geom size='1' group='3' mass='0'/></body></worldbody></mujoco>");
  const Scenario scenario = folder.read("m.xml");
  const Shape& shape = scenario.shapes.front();
  CHECK(shape.colour == "#00ff00");
  REQUIRE(shape.source);
  CHECK(shape.mesh == "assets/a.stl");
  const Pose geom{{0, 0, 1}, {0, 1, 0, 0}};
  const Quat reference{0.8, 0, 0.6, 0};
  for (const Vec3& v : tetrahedron().points) {
    const Vec3 moved = rotation_matrix(conjugate(reference)) * (v - Vec3{1, 2, 3});  // as mjCMesh does, then scaled
    const Vec3 expected = geom * (2 * moved),
               found = shape.at * Vec3{shape.scale.x * v.x, shape.scale.y * v.y, shape.scale.z * v.z};
    CHECK(norm(found - expected) < 1e-14);
  }
  REQUIRE(shape.more.size() == 1);  // group 3 is for collisions
  CHECK(shape.more[0].source->inside.triangles.size() == 2);
  CHECK(pack_meshes(mesh_sources(scenario.shapes)).warnings.empty());
}

TEST_CASE("a scenario's meshes, and those of SDF with a submesh") {
  const MeshFolder folder;
  folder.write("parts/a.obj", obj(tetrahedron()));
  folder.write("s.toml",
               "format = 1\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n"
               "shape = { mesh = \"parts/a.obj\", scale = 2 }\n");
  const Scenario scenario = folder.read("s.toml");
  REQUIRE(scenario.shapes.front().source);
  CHECK(pack_meshes(mesh_sources(scenario.shapes)).warnings.empty());
  folder.write("m.sdf",
               "<sdf version='1.9'><model name='m'><link name='l'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy>"
               "<izz>1</izz></inertia></inertial><visual name='v'><geometry><mesh><uri>parts/a.obj</uri><submesh><name>part"
               "</name></submesh></mesh></geometry></visual></link></model></sdf>");
  const Scenario sdf = folder.read("m.sdf");
  REQUIRE(sdf.shapes.front().source);
  CHECK(sdf.shapes.front().source->submesh == "part");
  CHECK(pack_meshes(mesh_sources(sdf.shapes)).warnings.empty());
}

}  // namespace
}  // namespace momentree::io
