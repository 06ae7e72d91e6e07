// Collada (.dae): triangles and polygons of the visual scene, placed by its nodes, in the colours of its materials. `up_axis` is
// not applied, as robot models expect it; `unit` is.
#include <algorithm>
#include <numbers>
#include <unordered_map>

#include <momentree/models/import/shape.hpp>
#include <momentree/models/mesh/formats.hpp>
#include <momentree/models/mesh/transform.hpp>
#include <momentree/models/xml/document.hpp>

namespace momentree::io::mesh {

namespace {

std::string_view attribute_of(XmlElement element, std::string_view name) {
  const auto i = element ? element.find(name) : std::nullopt;
  return i ? element.attribute(*i) : std::string_view{};
}

std::size_t index_attribute(XmlElement element, std::string_view name, std::size_t otherwise) {
  const std::string_view text = attribute_of(element, name);
  std::uint32_t value = 0;
  if (text.empty() || std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{}) return otherwise;
  return value;
}

class Collada {
 public:
  Collada(XmlElement root, const std::string& submesh) : root_(root), submesh_(submesh) {
    index(root);
    const std::string_view meter = attribute_of(child_of(child_of(root, "asset"), "unit"), "meter");
    if (!meter.empty()) unit_ = Words(meter).number();
  }

  Mesh read() {
    const Affine start = scaling({unit_, unit_, unit_});
    const XmlElement scene = target(attribute_of(child_of(child_of(root_, "scene"), "instance_visual_scene"), "url"));
    if (scene)
      read_nodes(scene, start, submesh_.empty(), 0);
    else
      each_child(child_of(root_, "library_geometries"), "geometry",
                 [&](XmlElement geometry) { read_geometry(geometry, start, {}); });
    return std::move(mesh_);
  }

 private:
  static constexpr int deepest = 64;
  static constexpr std::uint64_t most_work = 1u << 31;

  /// Elements refer to one another, so that a small file can ask for much: counts elements that are visited and bytes that are
  /// read.
  void spend(std::uint64_t work) const {
    work_ += work;
    if (work_ > most_work) refuse("it takes too long to read", "export it without instances");
  }
  template <class F>
  void each_child(XmlElement element, std::string_view name, const F& f) const {
    if (!element) return;
    for (const XmlElement child : element.children()) {
      spend(8);
      if (child.name() == name) f(child);
    }
  }
  XmlElement child_of(XmlElement element, std::string_view name) const {
    if (element)
      for (const XmlElement child : element.children()) {
        spend(8);
        if (child.name() == name) return child;
      }
    return {};
  }
  std::string_view text_of(XmlElement element) const {
    if (!element) return {};
    spend(element.text().size());
    return element.text();
  }

  void index(XmlElement element) {
    std::vector<XmlElement> waiting{element};
    while (!waiting.empty()) {
      const XmlElement at = waiting.back();
      waiting.pop_back();
      if (const std::string_view id = attribute_of(at, "id"); !id.empty()) by_id_.emplace(id, at);
      for (const XmlElement child : at.children()) waiting.push_back(child);
    }
  }
  /// The element that `#id` names; null if there is none.
  XmlElement target(std::string_view url) const {
    if (url.size() < 2 || url.front() != '#') return {};
    const auto found = by_id_.find(url.substr(1));
    return found == by_id_.end() ? XmlElement{} : found->second;
  }

  Affine placement(XmlElement node) const {
    Affine all;
    for (const XmlElement each : node.children()) {
      spend(8);
      Words words(text_of(each));
      if (each.name() == "matrix") {
        Affine one;
        for (int i = 0; i < 3; ++i) {
          for (double& entry : one.m[i]) entry = words.number();
          one.t[i] = words.number();
        }
        all = all * one;
      } else if (each.name() == "translate") {
        all = all * translation(words.vec3());
      } else if (each.name() == "scale") {
        all = all * scaling(words.vec3());
      } else if (each.name() == "rotate") {
        const Vec3 axis = words.vec3();
        const double angle = words.number() * std::numbers::pi / 180;
        if (norm(axis) > 1e-9) all = all * rotation(from_axis_angle(normalized(axis), angle));
      }
    }
    return all;
  }

  void read_nodes(XmlElement parent, const Affine& at, bool wanted, int depth) {
    if (depth > deepest) refuse("its nodes are nested too deeply, or in a cycle");
    const auto read_node = [&](XmlElement node) {
      const bool named = attribute_of(node, "name") == submesh_ || attribute_of(node, "id") == submesh_;
      read_nodes(node, at * placement(node), wanted || named, depth + 1);
    };
    each_child(parent, "node", read_node);
    each_child(parent, "instance_node", [&](XmlElement instance) {
      if (const XmlElement node = target(attribute_of(instance, "url"))) read_node(node);
    });
    each_child(parent, "instance_geometry", [&](XmlElement instance) {
      const XmlElement geometry = target(attribute_of(instance, "url"));
      if (!geometry || geometry.name() != "geometry") return;
      const bool named = attribute_of(geometry, "name") == submesh_ || attribute_of(geometry, "id") == submesh_;
      if (wanted || named) read_geometry(geometry, at, instance);
    });
  }

  /// The colour of the material that an instance binds to a symbol.
  std::string colour_of(std::string_view symbol, XmlElement instance) const {
    XmlElement material = by_id_.contains(symbol) ? by_id_.at(symbol) : XmlElement{};
    const XmlElement bound = child_of(child_of(instance, "bind_material"), "technique_common");
    each_child(bound, "instance_material", [&](XmlElement each) {
      if (attribute_of(each, "symbol") == symbol) material = target(attribute_of(each, "target"));
    });
    const XmlElement effect = target(attribute_of(child_of(material, "instance_effect"), "url"));
    const XmlElement technique = child_of(child_of(effect, "profile_COMMON"), "technique");
    if (!technique) return {};
    for (const XmlElement shading : technique.children()) {
      spend(8);
      const XmlElement colour = child_of(child_of(shading, "diffuse"), "color");
      if (!colour) continue;
      Words words(text_of(colour));
      const Vec3 rgb = words.vec3();
      return colour_text({rgb.x, rgb.y, rgb.z});
    }
    return {};
  }

  /// The points of a source, x y z with a stride.
  std::vector<Vec3> points_of(XmlElement source, const Affine& at) const {
    std::vector<Vec3> points;
    const XmlElement numbers = child_of(source, "float_array");
    if (!numbers) return points;
    const std::size_t stride = index_attribute(child_of(child_of(source, "technique_common"), "accessor"), "stride", 3);
    if (stride < 3 || stride > 64) refuse("a source of positions has fewer than three numbers per point");
    std::vector<double> row(stride);
    for (Words words(text_of(numbers)); !words.at_end();) {
      for (double& each : row) each = words.number();
      points.push_back(at({row[0], row[1], row[2]}));
    }
    return points;
  }

  void read_geometry(XmlElement geometry, const Affine& at, XmlElement instance) {
    const XmlElement mesh = child_of(geometry, "mesh");
    if (!mesh) return;
    for (const XmlElement primitives : mesh.children()) {
      const std::string_view kind = primitives.name();
      if (kind != "triangles" && kind != "polylist" && kind != "polygons" && kind != "tristrips" && kind != "trifans") continue;
      std::size_t offset = 0, stride = 0;
      XmlElement source;
      each_child(primitives, "input", [&](XmlElement input) {
        const std::size_t own = index_attribute(input, "offset", 0);
        if (own > 64) refuse("an <input> has an offset greater than 64");
        stride = std::max(stride, own + 1);
        if (attribute_of(input, "semantic") != "VERTEX") return;
        offset = own;
        each_child(target(attribute_of(input, "source")), "input", [&](XmlElement each) {
          if (attribute_of(each, "semantic") == "POSITION") source = target(attribute_of(each, "source"));
        });
      });
      if (!source) continue;
      MeshPart part;
      part.colour = colour_of(attribute_of(primitives, "material"), instance);
      part.points = points_of(source, at);
      read_primitives(primitives, kind, stride, offset, at.mirrors(), part);
      total_ += part.triangles.size();
      if (total_ > most_mesh_triangles) refuse("it has more than 4 million triangles", "simplify it");
      mesh_.parts.push_back(std::move(part));
    }
  }

  void read_primitives(XmlElement primitives, std::string_view kind, std::size_t stride, std::size_t offset, bool mirrored,
                       MeshPart& part) const {
    const auto add = [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      mirrored ? add_triangle(part, a, c, b) : add_triangle(part, a, b, c);
    };
    const auto index_in = [&](std::string_view word) {
      std::uint32_t index = 0;
      const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (error != std::errc{} || rest != word.data() + word.size()) refuse("an index is not a number");
      return index;
    };
    Words counts(text_of(child_of(primitives, "vcount")));
    each_child(primitives, "p", [&](XmlElement p) {
      Words words(text_of(p));
      std::vector<std::uint32_t> corners;
      std::size_t n = 0;
      for (std::string_view word = words.word(); !word.empty(); word = words.word(), ++n)
        if (n % stride == offset) corners.push_back(index_in(word));
      const auto fan = [&](std::size_t from, std::size_t count) {
        for (std::size_t k = 2; k < count; ++k) add(corners[from], corners[from + k - 1], corners[from + k]);
      };
      if (kind == "triangles") {
        for (std::size_t k = 0; k + 3 <= corners.size(); k += 3) fan(k, 3);
      } else if (kind == "tristrips") {
        for (std::size_t k = 2; k < corners.size(); ++k)
          k % 2 == 0 ? add(corners[k - 2], corners[k - 1], corners[k]) : add(corners[k - 1], corners[k - 2], corners[k]);
      } else if (kind == "polylist") {
        std::size_t from = 0;
        for (std::string_view word = counts.word(); !word.empty(); word = counts.word()) {
          const std::size_t count = index_in(word);
          if (count > corners.size() - from) refuse("a polygon has more corners than <p> has");
          fan(from, count);
          from += count;
        }
      } else {
        fan(0, corners.size());
      }
    });
  }

  XmlElement root_;
  const std::string& submesh_;
  std::unordered_map<std::string_view, XmlElement> by_id_;
  double unit_ = 1;
  std::size_t total_ = 0;
  mutable std::uint64_t work_ = 0;
  Mesh mesh_;
};

}  // namespace

Mesh read_collada(std::string_view content, const std::string& submesh) {
  SyntaxError error;
  const auto document = XmlDocument::parse(content, error, false);
  if (!document) refuse("line " + std::to_string(error.place.line) + ": " + error.what, error.hint);
  if (document->root().name() != "COLLADA") refuse("its root element is not <COLLADA>");
  return Collada(document->root(), submesh).read();
}

}  // namespace momentree::io::mesh
