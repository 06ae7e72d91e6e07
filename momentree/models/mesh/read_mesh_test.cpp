#include <momentree/models/mesh/read_mesh.hpp>

#include <doctest/doctest.h>

#include <momentree/models/mesh/test_meshes.hpp>
#include <tests/error_of.hpp>

namespace momentree::io {
namespace {

using namespace test;

void check_same(const Mesh& read, const std::vector<Corners>& expected, double tolerance = 0) {
  std::vector<Corners> found;
  for (const MeshPart& part : read.parts)
    for (const Corners& each : corners_of(part)) found.push_back(each);
  REQUIRE(found.size() == expected.size());
  double worst = 0;
  for (std::size_t t = 0; t < found.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, norm(found[t][k] - expected[t][k]));
  CHECK(worst <= tolerance);
}

/// y of glTF points up.
std::vector<Corners> upright(std::vector<Corners> all) {
  for (Corners& t : all)
    for (Vec3& p : t) p = {p.x, -p.z, p.y};
  return all;
}

TEST_CASE("every format reads the triangles that were written, with their colours") {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const MeshPart part = random_part(random, 3 + i % 40, 1 + i % 60);
    const std::vector<Corners> all = corners_of(part);
    check_same(read_mesh_text(text_stl(part), "a.stl"), all);
    check_same(read_mesh_text(binary_stl(part), "a.STL"), all);
    const Mesh from_obj = read_mesh_text(obj(part, "red"), "a.obj", "", [](const std::string& name) {
      return name == "m.mtl" ? std::optional<std::string>("newmtl red\nKd 1 0 0.2\n") : std::nullopt;
    });
    check_same(from_obj, all);
    CHECK(from_obj.parts.front().colour == "#ff0033");
    const Mesh from_collada = read_mesh_text(collada(part, "<node>" + instance() + "</node>"), "a.dae");
    check_same(from_collada, all);
    CHECK(from_collada.parts.front().colour == "#ff8000");
    for (const Mesh& mesh : {read_mesh_text(gltf(part), "a.gltf"), read_mesh_text(glb(part), "a.glb")}) {
      check_same(mesh, upright(all));
      CHECK(mesh.parts.front().colour == "#ff0080");  // 0.21586 of the light is half of the sRGB scale
    }
  }
}

TEST_CASE("nodes place their meshes: Collada and glTF against poses") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const MeshPart part = random_part(random, 10, 10);
    const Vec3 axis{any(random), any(random), any(random)}, t{any(random), any(random), any(random)};
    const double degrees = 180 * any(random), s = 0.5 + std::fabs(any(random));
    const Quat q = from_axis_angle(normalized(axis), degrees * 3.14159265358979323846 / 180);
    const Pose inner{t, q}, outer{{1, 2, 3}, Quat{0, 1, 0, 0}};  // half a turn about x
    std::vector<Corners> expected = corners_of(part);
    for (Corners& each : expected)
      for (Vec3& p : each) p = outer * (inner * (s * p));
    const std::string collada_node = "<node><translate>1 2 3</translate><rotate>1 0 0 180</rotate><node><translate>" +
                                     text_of(t) + "</translate><rotate>" + text_of(axis) + " " + text_of(degrees) +
                                     "</rotate><scale>" + text_of(Vec3{s, s, s}) + "</scale>" + instance() + "</node></node>";
    check_same(read_mesh_text(collada(part, collada_node), "a.dae"), expected, 1e-4);
    const auto list = [](const Vec3& v) { return "[" + text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z) + "]"; };
    const std::string nodes =
        R"({"children": [1], "translation": [1, 2, 3], "rotation": [1, 0, 0, 0]}, {"mesh": 0, "translation": )" + list(t) +
        R"(, "rotation": [)" + text_of(q.x) + "," + text_of(q.y) + "," + text_of(q.z) + "," + text_of(q.w) + R"(], "scale": )" +
        list({s, s, s}) + "}";
    check_same(read_mesh_text(glb(part, nodes), "a.glb"), upright(expected), 1e-4);
    for (Corners& each : expected)
      for (Vec3& p : each) p = 0.001 * p;
    check_same(read_mesh_text(collada(part, collada_node, "<unit meter='0.001'/>"), "a.dae"), expected, 1e-7);
  }
}

TEST_CASE("a mirrored node keeps its triangles' outsides; polygons become fans, and strips alternate") {
  MeshPart part;
  part.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  part.triangles = {{0, 1, 2}};
  const Mesh mirrored = read_mesh_text(collada(part, "<node><scale>-1 1 1</scale>" + instance() + "</node>"), "a.dae");
  const Corners t = corners_of(mirrored.parts.front()).front();
  CHECK(cross(t[1] - t[0], t[2] - t[0]).z > 0);
  const Mesh polygon = read_mesh_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n", "a.obj");
  CHECK(polygon.triangles() == 3);
  double area = 0;
  for (const Corners& each : corners_of(polygon.parts.front())) area += 0.5 * cross(each[1] - each[0], each[2] - each[0]).z;
  CHECK(area == doctest::Approx(1.5));
}

TEST_CASE("a submesh is the part of that name alone") {
  const std::string two = "o left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no right\nv 0 0 1\nf 1 2 4\nf 2 3 4\n";
  CHECK(read_mesh_text(two, "a.obj").triangles() == 3);
  CHECK(read_mesh_text(two, "a.obj", "right").triangles() == 2);
  CHECK(error_of([&] { read_mesh_text(two, "a.obj", "middle"); }).find("no triangles in a part of that name") !=
        std::string::npos);
  std::mt19937 random(3);
  const MeshPart part = random_part(random, 5, 4);
  for (const char* name : {"part", "n"}) {
    CHECK(read_mesh_text(collada(part, "<node name='n'>" + instance() + "</node>"), "a.dae", name).triangles() == 4);
    CHECK(read_mesh_text(gltf(part, R"({"mesh": 0, "name": "n"})"), "a.gltf", name).triangles() == 4);
  }
}

TEST_CASE("wrong files are refused with the reason") {
  const struct {
    std::string content;
    const char* name;
    const char* problem;
  } cases[] = {
      {"", "a.stl", "too short for an STL file"},
      {std::string(80, 'x') + "\xff\xff\xff\x7f", "a.stl", "ends before the last of its 2147483647 triangles"},
      {"solid a\nfacet normal 0 0 1\nvertex 1 2 3\nendfacet\n", "a.stl", "a facet has fewer than three vertices"},
      {"solid a\nvertex 1 2 nan\n", "a.stl", "a coordinate is not a number"},
      {"solid a\nvertex 1 2 1e999\n", "a.stl", "a coordinate is not a number"},
      {"solid a\nendsolid\n", "a.stl", "it has no triangles"},
      {"v 0 0 0\nv 1 0 0\nf 1 2 3\n", "a.obj", "a face has a vertex that does not exist"},
      {"v 0 0 0\nf 1 1 -2\n", "a.obj", "a face has a vertex that does not exist"},
      {"v 0 0 0\nf 1 1 0\n", "a.obj", "a face has a vertex that is not a number"},
      {"v 0 0 0\nf 1 1\n", "a.obj", "a face has fewer than three vertices"},
      {"v 0 0\nf 1 1 1\n", "a.obj", "it ends where a number is expected"},
      {"v 0 0 1e300\nf 1 1 1\n", "a.obj", "larger than 1e12"},
      {"<!DOCTYPE lolz [<!ENTITY a 'x'>]><COLLADA/>", "a.dae", "document type"},
      {"<robot/>", "a.dae", "its root element is not <COLLADA>"},
      {"<COLLADA><a></COLLADA>", "a.dae", "line 1: "},
      {"{\"a\": 1,}", "a.gltf", ""},
      {"glTF", "a.glb", "it is not of version 2 of the format"},
      {"x", "a.step", "its format is not known"},
  };
  for (const auto& each : cases) {
    CAPTURE(each.content);
    const std::string error = error_of([&] { read_mesh_text(each.content, each.name); });
    CHECK(error != "");
    CHECK(error.find(each.problem) != std::string::npos);
  }
  std::mt19937 random(5);
  const MeshPart part = random_part(random, 4, 2);
  const auto changed = [&](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
  };
  const std::string cycle = R"({"children": [0], "mesh": 0})", deep = "<node id='n'><instance_node url='#n'/></node>";
  for (const auto& [content, name, problem] : std::vector<std::array<std::string, 3>>{
           {changed(gltf(part), R"("count": 4)", R"("count": 4000000000)"), "a.gltf", "reaches beyond its view"},
           {changed(gltf(part), R"("count": 4)", R"("count": -4)"), "a.gltf", "'count' is not a count"},
           {changed(gltf(part), R"("count": 4)", R"("count": 1)"), "a.gltf", "a vertex that does not exist"},
           {changed(gltf(part), R"("byteOffset": 48)", R"("byteOffset": 4294967295)"), "a.gltf", "beyond its buffer"},
           {changed(gltf(part), "base64,", "base64,*"), "a.gltf", "not valid base64"},
           {changed(gltf(part), R"("uri": "data:)", R"("uri": "../)"), "a.gltf", "not a file in the mesh's folder"},
           {gltf(part, cycle), "a.gltf", "one has several parents"},
           {collada(part, deep), "a.dae", "nested too deeply"}}) {
    CAPTURE(content);
    CHECK(error_of([&, &text = content, &file = name] { read_mesh_text(text, file); }).find(problem) != std::string::npos);
  }
}

// Whatever is read is a mesh with valid indices and finite numbers.
void judge_mesh(const std::string& content, const char* name) {
  try {
    for (const MeshPart& part : read_mesh_text(content, name).parts)
      for (const auto& triangle : part.triangles)
        for (const std::uint32_t corner : triangle) {
          REQUIRE(corner < part.points.size());
          REQUIRE(std::isfinite(norm(part.points[corner])));
        }
  } catch (const Error&) {
  }
}

TEST_CASE("files cut off anywhere, and files with changed bytes, are refused or read as other meshes") {
  std::mt19937 random(13);
  const MeshPart part = random_part(random, 6, 5);
  const std::pair<std::string, const char*> files[] = {
      {text_stl(part), "a.stl"}, {binary_stl(part), "a.stl"},
      {obj(part), "a.obj"},      {collada(part, "<node>" + instance() + "</node>"), "a.dae"},
      {gltf(part), "a.gltf"},    {glb(part), "a.glb"}};
  for (const auto& [content, name] : files) {
    for (std::size_t size = 0; size < content.size(); ++size) judge_mesh(content.substr(0, size), name);
    std::uniform_int_distribution<std::size_t> where(0, content.size() - 1);
    std::uniform_int_distribution<int> byte(0, 255);
    for (int i = 0; i < 2000; ++i) {
      std::string changed = content;
      for (int k = 0; k <= i % 3; ++k) changed[where(random)] = static_cast<char>(byte(random));
      judge_mesh(changed, name);
    }
  }
}

}  // namespace
}  // namespace momentree::io
