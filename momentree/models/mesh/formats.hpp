#pragma once
// The mesh formats, one reader each. Internal to the mesh reader.
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <momentree/base/error.hpp>
#include <momentree/models/mesh/read_mesh.hpp>

namespace momentree::io::mesh {

Mesh read_stl(std::string_view content);
Mesh read_obj(std::string_view content, const std::string& submesh, const CompanionFiles& companions);
Mesh read_collada(std::string_view content, const std::string& submesh);
/// Also the binary form. Y, which points up in the format, becomes z.
Mesh read_gltf(std::string_view content, const std::string& submesh, const CompanionFiles& companions);

[[noreturn]] inline void refuse(std::string what, std::string hint = {}) { throw_error({std::move(what), "", std::move(hint)}); }

/// Adds a triangle; throws if the mesh becomes too large or an index is out of range.
inline void add_triangle(MeshPart& part, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::uint64_t points = part.points.size();
  if (a >= points || b >= points || c >= points) refuse("a triangle has a vertex that does not exist");
  if (part.triangles.size() >= most_mesh_triangles) refuse("it has more than 4 million triangles", "simplify it");
  part.triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
}

/// Words of a text, separated by blanks.
class Words {
 public:
  explicit Words(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}
  /// The next word; empty at the end.
  std::string_view word() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    const char* begin = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  bool at_end() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    return at_ == end_;
  }
  /// The next number; throws if the word is none, or not finite.
  double number() {
    const std::string_view text = word();
    if (text.empty()) refuse("it ends where a number is expected");
    const char* begin = text.data() + (text.front() == '+');
    double value = 0;
    const auto [rest, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range && std::fabs(std::strtod(std::string(text).c_str(), nullptr)) < 1) return 0;
    if (error != std::errc{} || rest != text.data() + text.size() || !std::isfinite(value))
      refuse("a coordinate is not a number");
    return value;
  }
  Vec3 vec3() {
    const double x = number(), y = number();
    return {x, y, number()};
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  const char* at_;
  const char* end_;
};

/// A number of type T in little-endian bytes; `at` must be in range.
template <class T>
T little_endian(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

}  // namespace momentree::io::mesh
