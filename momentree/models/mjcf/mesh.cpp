// Meshes of <asset>, which geoms name.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <momentree/models/mesh/source.hpp>
#include <momentree/models/mjcf/parts.hpp>
#include <momentree/text/files/file_name.hpp>

namespace momentree::io::mjcf {

namespace {

namespace fs = std::filesystem;

// Points and triangles that are given as attributes.
void read_inside(Attributes& attributes, XmlElement element, MeshAsset& asset, XmlFile& file) {
  constexpr std::size_t most_numbers = 10'000'000;
  const auto vertices = attributes.numbers("vertex", 3, most_numbers), faces = attributes.numbers("face", 3, most_numbers);
  if (attributes.has("vertex") && !attributes.has("face"))
    file.once(Severity::note, "a mesh of points without faces is not drawn", "give it faces, or a file", {element});
  if (!vertices || !faces) return;
  if (vertices->size() % 3 != 0)
    return attributes.error("vertex", "vertex: the number of coordinates is not a multiple of three");
  if (faces->size() % 3 != 0) return attributes.error("face", "face: the number of indices is not a multiple of three");
  auto source = std::make_shared<MeshSource>();
  for (std::size_t i = 0; i < vertices->size(); i += 3)
    source->inside.points.push_back({(*vertices)[i], (*vertices)[i + 1], (*vertices)[i + 2]});
  for (std::size_t i = 0; i < faces->size(); i += 3) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double corner = (*faces)[i + k];
      if (!(corner >= 0 && corner < static_cast<double>(source->inside.points.size())) || corner != std::floor(corner))
        return attributes.error("face", "face: an index is not that of a vertex");
      triangle[k] = static_cast<std::uint32_t>(corner);
    }
    source->inside.triangles.push_back(triangle);
  }
  source->file = file.path();
  source->place = element.place();
  asset.shape.kind = Shape::Kind::mesh;
  asset.shape.source = std::move(source);
}

// The vertices are s·Rᵀ(v − p), with the scale s, refpos p and refquat R: a placement of the scaled mesh, unless a turned mesh is
// scaled differently along its axes.
bool place(Attributes& attributes, MeshAsset& asset) {
  const Vec3 s = attributes.vec3("scale").value_or(Vec3{1, 1, 1}), p = attributes.vec3("refpos").value_or(Vec3{});
  Quat r{};
  if (const auto q = attributes.numbers("refquat", 4)) {
    const double length = std::hypot(std::hypot((*q)[0], (*q)[1]), std::hypot((*q)[2], (*q)[3]));
    if (length < 1e-9) {
      attributes.error("refquat", "refquat: has no direction", "its length is zero");
      return true;
    }
    r = normalized(Quat{(*q)[0] / length, (*q)[1] / length, (*q)[2] / length, (*q)[3] / length});
  }
  asset.shape.scale = s;
  const bool turned = r.x != 0 || r.y != 0 || r.z != 0;
  if (turned && !(s.x == s.y && s.y == s.z)) return false;
  const Vec3 back = rotation_matrix(conjugate(r)) * p;
  asset.shape.at = {{-s.x * back.x, -s.y * back.y, -s.z * back.z}, conjugate(r)};
  return true;
}

}  // namespace

void read_mesh_asset(XmlElement element, Reading& reading) {
  XmlFile& file = reading.file_of(element);
  check_attributes(element,
                   {"file", "vertex", "face", "normal", "texcoord", "scale", "refpos", "refquat", "smoothnormal", "maxhullvert",
                    "inertia", "content_type", "builtin", "params", "material", "octree_maxdepth"},
                   reading);
  Attributes attributes(element, "", reading);
  MeshAsset asset;
  std::string name;
  if (const auto own = element.find("name")) name = element.attribute(*own);
  if (const auto given = attributes.string("file")) {
    if (name.empty()) name = fs::path(*given).stem().string();
    const std::string path = (reading.compiler.strippath ? fs::path(*given).filename() : fs::path(*given)).generic_string();
    const std::string in_folder = (fs::path(reading.compiler.meshdir) / path).lexically_normal().generic_string();
    if (given->empty() || leaves_folder(in_folder))
      file.once(Severity::note, "a mesh is not in the model's folder or below it: pictures leave it out",
                "the motion does not depend on it", attributes.at("file"));
    else
      reading.import.read_mesh(in_folder, attributes.at("file"), asset.shape, file);
  } else {
    read_inside(attributes, element, asset, file);
  }
  if (!place(attributes, asset)) {
    file.once(Severity::note, "a mesh with both refquat and different scales along its axes is not drawn", "", {element});
    asset.shape = {};
  }
  if (!name.empty()) reading.meshes.emplace(std::move(name), std::move(asset));
}

Shape mesh_shape(const std::string& name, const Pose& at, const Reading& reading) {
  const auto found = reading.meshes.find(name);
  if (found == reading.meshes.end()) return {};
  Shape shape = found->second.shape;
  shape.at = at * shape.at;
  return shape;
}

}  // namespace momentree::io::mjcf
