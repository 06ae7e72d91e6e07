// Height fields of scenarios and model files, which are read, written and drawn.
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/models/import/height_grid.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

const std::string ball =
    "[[mechanism]]\nname = \"m\"\nroot = \"free\"\npose = { xyz = [0, 0, 9] }\n[[mechanism.body]]\nname = \"m\"\nmass = 1\n"
    "inertia = 0.01\ncollision = { sphere = 0.1 }\n";
std::string scenario(const std::string& shape) { return "format = 1\n[world]\ncollision = " + shape + "\n" + ball; }
std::string mjcf(const std::string& assets, const std::string& geom) {
  return "<mujoco><asset>" + assets + "</asset><worldbody><geom type='hfield' hfield='h' " + geom +
         "/><body name='m' pos='0 0 9'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>";
}

const contact::HeightField& field_of(const ReadResult& result) {
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  for (const Collider& each : result.scenario->model.colliders())
    if (each.field) return *each.field;
  FAIL("no height field");
  std::abort();
}
std::string said(const ReadResult& result) { return rendered(result.diagnostics); }

std::string big_endian(std::uint32_t x) {
  return {static_cast<char>(x >> 24), static_cast<char>(x >> 16), static_cast<char>(x >> 8), static_cast<char>(x)};
}
std::uint32_t crc(const std::string& text) {
  std::uint32_t sum = 0xffffffffu;
  for (const char c : text) {
    sum ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) sum = (sum >> 1) ^ (sum & 1 ? 0xedb88320u : 0u);
  }
  return ~sum;
}
// A grey PNG image, without compression.
std::string png(std::uint32_t columns, const std::vector<int>& levels, int bits) {
  const auto chunk = [](const std::string& text) {
    return big_endian(static_cast<std::uint32_t>(text.size() - 4)) + text + big_endian(crc(text));
  };
  std::string raw;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    if (k % columns == 0) raw += '\0';
    if (bits == 16) raw += static_cast<char>(levels[k] >> 8);
    raw += static_cast<char>(levels[k]);
  }
  std::uint32_t a = 1, b = 0;
  for (const char c : raw) a = (a + static_cast<unsigned char>(c)) % 65521, b = (b + a) % 65521;
  const auto length = static_cast<std::uint16_t>(raw.size()), other = static_cast<std::uint16_t>(~length);
  const std::string data = std::string("\x78\x01\x01") + static_cast<char>(length) + static_cast<char>(length >> 8) +
                           static_cast<char>(other) + static_cast<char>(other >> 8) + raw + big_endian(b << 16 | a);
  const auto rows = static_cast<std::uint32_t>(levels.size() / columns);
  const std::string header = big_endian(columns) + big_endian(rows) + static_cast<char>(bits) + std::string(4, '\0');
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR" + header) + chunk("IDAT" + data) + chunk("IEND");
}
bool reads_images() {
  test::TemporaryFolder folder;
  write(folder / "a.png", png(2, {0, 1, 2, 3}, 8));
  return test::error_of([&] { read_height_image(folder / "a.png"); }).empty();
}

}  // namespace

TEST_CASE("heights: rows of a scenario, from the largest y down, with their size") {
  const contact::HeightField field = field_of(read_scenario_text(
      scenario("{ heightmap = [[4, 5, 6], [1, 2, 3]], size = [4, \"200 cm\", 0.5], at = { xyz = [0, 0, -2] } }"), "s.toml"));
  CHECK(field.columns == 3);
  CHECK(field.rows == 2);
  CHECK(field.x == 4);
  CHECK(field.y == 2);
  CHECK(field.heights == std::vector<double>{0.5, 1, 1.5, 2, 2.5, 3});  // from −y on
  CHECK(field.lowest == 0.5);
  CHECK(field.highest == 3);
  CHECK(field.at.position == Vec3{0, 0, -2});
}

TEST_CASE("heights: of MJCF, as MuJoCo 3.17 reads numbers, images and its own files") {
  test::TemporaryFolder folder;
  const auto read = [&](const std::string& hfield, const std::string& geom) {
    write(folder / "m.xml", mjcf("<hfield name='h' size='2 1 10 0.1' " + hfield + "/>", geom));
    return read_scenario(folder / "m.xml");
  };
  // mjModel.hfield_data of the same three files; scaled to 0 … 1.
  const auto check = [](const contact::HeightField& field, const std::vector<double>& expected) {
    REQUIRE(field.heights.size() == 6);
    for (std::size_t k = 0; k < 6; ++k) CHECK(field.heights[k] == doctest::Approx(10 * expected[k]));
    CHECK(field.x == 4);
    CHECK(field.y == 2);
  };
  const std::vector<double> flipped{0.6, 0.8, 1, 0, 0.2, 0.4}, straight{0, 0.2, 0.4, 0.6, 0.8, 1};
  check(field_of(read("nrow='2' ncol='3' elevation='10 20 30 40 50 60'", "")), flipped);
  check(field_of(read("nrow='2' ncol='3'", "")), std::vector<double>(6, 0));
  std::string file("\2\0\0\0\3\0\0\0", 8);
  for (const float height : {10.f, 20.f, 30.f, 40.f, 50.f, 60.f}) file.append(reinterpret_cast<const char*>(&height), 4);
  write(folder / "h.bin", file);
  check(field_of(read("file='h.bin'", "")), straight);
  if (!reads_images()) return;
  write(folder / "h.png", png(3, {10, 20, 30, 40, 50, 60}, 8));
  const ReadResult placed = read("file='h.png'", "pos='1 2 3' euler='0 0 90'");
  check(field_of(placed), flipped);
  CHECK(norm(field_of(placed).at * Vec3{1, 0, 0} - Vec3{1, 3, 3}) < 1e-12);
  CHECK(placed.scenario->model.contact_law(placed.scenario->model.body("m/m"), ground).friction == 1);
}

TEST_CASE("heights: images of 8 and 16 bits in scenarios and SDF") {
  if (!reads_images()) return;
  test::TemporaryFolder folder;
  write(folder / "a.png", png(2, {0, 51, 102, 255}, 8));
  write(folder / "b.png", png(2, {0, 13107, 26214, 65535}, 16));
  for (const char* const image : {"a.png", "b.png"}) {
    write(folder / "s.toml", scenario("{ heightmap = \"" + std::string(image) + "\", size = [1, 1, 2] }"));
    const contact::HeightField field = field_of(read_scenario(folder / "s.toml"));
    const double expected[] = {0.8, 2, 0, 0.4};
    for (std::size_t k = 0; k < 4; ++k) CHECK(field.heights[k] == doctest::Approx(expected[k]));
  }
  const std::string inertial = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
  write(folder / "m.sdf",
        "<sdf version='1.9'><world name='w'><model name='t'><static>true</static><pose>0 0 1 0 0 0</pose><link name='l'>" +
            inertial +
            "<collision name='c'><geometry><heightmap><uri>model://t/a.png</uri><size>6 8 2</size><pos>1 2 "
            "-3</pos></heightmap></geometry>"
            "</collision></link></model><model name='m'><pose>0 0 9 0 0 0</pose><link name='m'>" +
            inertial +
            "<collision "
            "name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link></model></world></sdf>");
  const contact::HeightField field = field_of(read_scenario(folder / "m.sdf"));
  CHECK(field.x == 6);
  CHECK(field.y == 8);
  CHECK(field.heights[1] == doctest::Approx(2));
  CHECK(norm(field.at.position - Vec3{1, 2, -2}) < 1e-12);
}

TEST_CASE("heights: what is written reads back to the last bit, and is drawn") {
  const ReadResult first = read_scenario_text(
      scenario(
          "[{ heightmap = [[0.1, 0.2, 0.3], [0.7, 0.5, 0.9]], size = [4, 2, 1], at = { xyz = [1, 2, 3], rpy = [0.1, 0, 0] } }]"),
      "s.toml");
  const contact::HeightField field = field_of(first);
  for (const std::string& text : {to_toml(first.scenario->model, {}, true), to_toml(*first.scenario, "").text}) {
    INFO(text);
    const contact::HeightField again = field_of(read_scenario_text(text, "again.toml"));
    CHECK(again.heights == field.heights);
    CHECK(norm(again.at.position - field.at.position) < 1e-15);
  }
  const std::vector<GroundShape> drawn = ground_shapes(first.scenario->model);
  REQUIRE(drawn.size() == 1);
  CHECK(drawn[0].mesh.points.size() == 6);
  CHECK(drawn[0].mesh.triangles.size() == 4);
  CHECK(norm(drawn[0].mesh.points[0] - Vec3{-2, -1, 0.7}) < 1e-15);
}

TEST_CASE("heights: mistakes are errors that say what is wrong, of what is missing in a model a warning") {
  const auto of = [](const std::string& shape) { return said(read_scenario_text(scenario(shape), "s.toml")); };
  CHECK(of("{ heightmap = [[0, 1], [1, 2, 3]], size = [1, 1, 1] }")
            .find("s.toml:3:36: error: heightmap: row 2 has 3 numbers, the first one 2") != std::string::npos);
  CHECK(of("{ heightmap = [[0, 1]], size = [1, 1, 1] }").find("heightmap: expected rows of numbers") != std::string::npos);
  CHECK(of("{ heightmap = [[0, 1], [1, 2]], size = [1, -1, 1] }").find("size: its three numbers must be greater than 0") !=
        std::string::npos);
  CHECK(of("{ heightmap = [[0, 1], [1, 2]] }").find("has no 'size'") != std::string::npos);
  CHECK(of("{ box = [1, 1, 1], size = [1, 1, 1] }").find("size") != std::string::npos);
  test::TemporaryFolder folder;
  write(folder / "s.toml", scenario("{ heightmap = \"none.png\", size = [1, 1, 1] }"));
  CHECK(said(read_scenario(folder / "s.toml")).find("error: heightmap: there is no file 'none.png'") != std::string::npos);
  const auto model = [&](const std::string& hfield) {
    write(folder / "m.xml", mjcf("<hfield name='h' " + hfield + "/>", ""));
    return said(read_scenario(folder / "m.xml"));
  };
  CHECK(model("nrow='2' ncol='3' elevation='1 2 3' size='1 1 1 1'")
            .find("elevation: 6 numbers are needed, for nrow rows of ncol") != std::string::npos);
  CHECK(model("nrow='2' ncol='3' size='1 -1 1 1'").find("size: its four numbers must be greater than 0") != std::string::npos);
  CHECK(model("size='1 1 1 1'").find("has nrow and ncol, both at least 2") != std::string::npos);
  CHECK(model("file='none.png' size='1 1 1 1'")
            .find("warning: the height field 'none.png' is not in the model's folder or below it: "
                  "nothing touches it") != std::string::npos);
  write(folder / "h.bin", std::string("\2\0\0\0\3\0\0\0", 8));
  CHECK(model("file='h.bin' size='1 1 1 1'").find("it has 8 bytes, and begins with 2 rows and 3 columns") != std::string::npos);
  write(folder / "m.xml", mjcf("", ""));
  CHECK(said(read_scenario(folder / "m.xml")).find("there is no <hfield> 'h' in <asset>") != std::string::npos);
  if (!reads_images()) return;
  write(folder / "h.png", png(3, {1, 2, 3, 4, 5, 6}, 8).substr(0, 50));
  CHECK(model("file='h.png' size='1 1 1 1'").find("is no PNG image that can be read") != std::string::npos);
}
