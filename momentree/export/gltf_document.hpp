#pragma once
// A glTF 2.0 document in binary form (.glb): its objects are added one by one, in the terms of the specification
// (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html).
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/export/triangles.hpp>

namespace momentree::io {

using Float3 = std::array<float, 3>;
using Float4 = std::array<float, 4>;

class GltfDocument {
 public:
  struct Node {
    std::string name{};
    int mesh = -1;  ///< −1: none
    std::optional<Float3> translation{};
    std::optional<Float4> rotation{};  ///< x, y, z, w
    std::optional<Float3> scale{};
    std::string extras{};  ///< JSON; empty: none
    std::vector<int> children{};
  };
  enum class Path { translation, rotation, scale };

  /// Adds a node below another one; −1: a root of the scene. Returns its number.
  int add_node(Node node, int parent);
  /// Number of the material of this colour, "#rrggbb"; `open`: visible from both sides.
  int material(const std::string& colour, bool open);
  /// Adds triangles for meshes of any material. Returns their number.
  int add_triangles(const Triangles& triangles);
  int add_mesh(int triangles, int material);

  /// Adds times of keys (s), strictly increasing, not negative. Returns their number, for animate().
  int add_times(std::span<const float> times);
  /// Animates a node: `width` numbers (3, or 4 for a rotation) per key. `steps`: without interpolation.
  void animate(int node, Path path, int times, std::span<const float> values, bool steps);

  /// JSON of the scene's extras.
  void set_extras(std::string json) { extras_ = std::move(json); }
  /// The file. Throws Error, without a place, if it would have more than 4 GiB.
  std::string binary(const std::string& generator, const std::string& title) const;

 private:
  enum class Target { none = 0, vertices = 34962, indices = 34963 };
  struct View {
    std::size_t offset, length;
    Target target;
  };
  struct Accessor {
    int view, component;
    std::size_t count;
    const char* type;
    std::vector<float> low{}, high{};
  };
  struct Mesh {
    int triangles, material;
  };
  struct Geometry {
    int positions, normals, indices;
  };
  struct Material {
    std::string colour;
    bool open;
  };
  struct Sampler {
    int input, output;
    bool steps;
  };
  struct Channel {
    int node;
    Path path;
  };

  int add_view(std::string_view bytes, Target target);
  int add_floats(std::span<const float> numbers, std::size_t width, Target target, bool bounds);
  std::string json(const std::string& generator, const std::string& title) const;

  std::vector<Node> nodes_;
  std::vector<int> roots_;
  std::vector<Material> materials_;
  std::vector<Geometry> geometries_;
  std::vector<Mesh> meshes_;
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
  std::vector<Sampler> samplers_;
  std::vector<Channel> channels_;  ///< by sampler
  std::string bytes_, extras_;
};

}  // namespace momentree::io
