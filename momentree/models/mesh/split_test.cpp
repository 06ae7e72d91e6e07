// Meshes as convex parts, as far as that needs no library. python/tests/test_split.py has what needs it.
#include <cstdlib>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/solid.hpp>
#include <momentree/models/mesh/split.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

// Triangles with corners of their own, as in STL files.
MeshPart prism(const std::vector<Vec3>& outline, double height, const std::vector<std::array<std::uint32_t, 3>>& bottom) {
  MeshPart mesh;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto n = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), {a, b, c}), mesh.triangles.push_back({n, n + 1, n + 2});
  };
  const Vec3 up{0, 0, height};
  for (const auto& [a, b, c] : bottom) {
    add(outline[a], outline[c], outline[b]);
    add(outline[a] + up, outline[b] + up, outline[c] + up);
  }
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 &a = outline[i], b = outline[(i + 1) % outline.size()];
    add(a, b, b + up), add(a, b + up, a + up);
  }
  return mesh;
}
MeshPart box_at(const Vec3& p, double size) {
  return prism({p, p + Vec3{size, 0, 0}, p + Vec3{size, size, 0}, p + Vec3{0, size, 0}}, size, {{0, 1, 2}, {0, 2, 3}});
}
MeshPart together(MeshPart one, const MeshPart& other) {
  const auto first = static_cast<std::uint32_t>(one.points.size());
  one.points.insert(one.points.end(), other.points.begin(), other.points.end());
  for (const auto& [a, b, c] : other.triangles) one.triangles.push_back({first + a, first + b, first + c});
  return one;
}
MeshPart inside_out(MeshPart mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  return mesh;
}
MeshPart angle() {
  return prism({{0, 0, 0}, {1, 0, 0}, {1, 0.3, 0}, {0.3, 0.3, 0}, {0.3, 1, 0}, {0, 1, 0}}, 0.5,
               {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}});
}
void without_library(const char* path = "/nowhere/lib_coacd.so") { ::setenv("MOMENTREE_COACD", path, 1); }

}  // namespace

TEST_CASE("split: shells that are convex are parts as they are, and the same mesh is split once") {
  without_library();
  // They overlap, and the mesh may be inside out.
  const MeshPart boxes = together(box_at({}, 1), box_at({0.5, 0.5, 0.5}, 2));
  for (const MeshPart& mesh : {boxes, inside_out(boxes)}) {
    const auto split = split_mesh(mesh, 0.05);
    CHECK(split->problem == "");
    REQUIRE(split->parts.size() == 2);
    CHECK(contact::volume(contact::hull(split->parts[0])) == doctest::Approx(1));
    CHECK(contact::volume(contact::hull(split->parts[1])) == doctest::Approx(8));
    CHECK(split_mesh(mesh, 0.05) == split);
    CHECK(split_mesh(mesh, 0.1) != split);
  }
  for (const Vec3& corner : {Vec3{1, 1, 0}, Vec3{1, 1, 1}}) {  // with an edge, or a corner, in common
    const auto split = split_mesh(together(box_at({}, 1), box_at(corner, 1)), 0.05);
    CHECK(split->problem == "");
    CHECK(split->parts.size() == 2);
  }
}

TEST_CASE("split: what prevents it is said") {
  without_library();
  CHECK(split_mesh(angle(), 0.05)->problem.starts_with("cannot be split without CoACD: /nowhere/lib_coacd.so: "));
  CHECK(split_mesh(angle(), 0.05)->hint.starts_with("pip install coacd; "));
  // A cavity belongs to the shell around it, which is not convex with it.
  const MeshPart hollow = together(box_at({}, 1), inside_out(box_at({0.2, 0.2, 0.2}, 0.6)));
  CHECK(split_mesh(hollow, 0.05)->problem.starts_with("cannot be split without CoACD"));
  MeshPart turned = angle();
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  CHECK(split_mesh(turned, 0.05)->problem == "cannot be split: some of its triangles face inwards, others outwards");
  without_library("libm.so.6");
  CHECK(split_mesh(angle(), 0.05)->problem == "cannot be split: libm.so.6 is another version of CoACD");
}
