// An animated USD file as text (.usda), in metres and with z upwards.
//
// The prim /world turns the world so that gravity points along −z. Below it, each body is an Xform, whose translation (double
// precision) and orientation have a sample at each row; there are 60 time codes per second, and the first row is at 0. Names are
// valid identifiers; `displayName` is the body's own. Below a body are its solids. Bars are prims of their own, invisible when
// they are not there. Materials change in steps where mechanisms do. `customLayerData` has the start, the status and the events.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <momentree/base/characters.hpp>
#include <momentree/export/exporter.hpp>
#include <momentree/export/solids.hpp>
#include <momentree/text/colour.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr double codes_per_second = 60;

/// Control characters become spaces, and bytes that are not UTF-8 U+FFFD.
std::string usd_string(const std::string& text) {
  std::string result = "\"";
  const std::string_view words = text;
  for (std::size_t i = 0; i < words.size();) {
    const std::size_t length = character_length(words, i);
    if (words[i] == '"' || words[i] == '\\') result += '\\';
    if (length == 0)
      result += "\ufffd";
    else if (static_cast<unsigned char>(words[i]) < ' ')
      result += ' ';
    else
      result += words.substr(i, length);
    i += std::max<std::size_t>(length, 1);
  }
  return result + '"';
}

template <class Range, class Text>
std::string listed(const Range& items, const Text& text) {
  std::string result;
  for (const auto& item : items) {
    if (!result.empty()) result += ", ";
    result += text(item);
  }
  return result;
}

std::string usd_tuple(std::initializer_list<double> numbers, int digits = 0) {
  return "(" + listed(numbers, [&](double x) { return digits > 0 ? rounded_text(x, digits) : number_text(x); }) + ")";
}
std::string exact_tuple(const Vec3& v) { return usd_tuple({v.x, v.y, v.z}); }
std::string short_tuple(const Vec3& v) { return usd_tuple({v.x, v.y, v.z}, 9); }
std::string short_tuple(const Quat& q) { return usd_tuple({q.w, q.x, q.y, q.z}, 9); }

/// Linear light of "#rrggbb".
std::string usd_colour(const std::string& colour) {
  const Rgb rgb = rgb_of(colour);
  return usd_tuple({linear_light(rgb.r), linear_light(rgb.g), linear_light(rgb.b)}, 5);
}

/// Values from time codes on.
using Samples = std::vector<std::pair<double, std::string>>;

class UsdBuilder {
 public:
  explicit UsdBuilder(const Drawing& drawing) : drawing_(drawing) {}

  std::string build() {
    rows_ = keys_of<double>(drawing_, [this](double time) { return code_of(time); });
    write_header();
    const Vec3& g = drawing_.run.gravity;
    const Vec3 up = norm(g) > 0 ? normalized(-g) : Vec3{0, 0, 1};
    open("Xform", "world", "world");
    line("quatf xformOp:orient = " + short_tuple(shortest_turn(up, {0, 0, 1})));
    line(R"(uniform token[] xformOpOrder = ["xformOp:orient"])");
    std::set<std::string> taken{"materials"};
    for (std::size_t b = 0; b < drawing_.run.bodies.size(); ++b) write_body(b, taken);
    for (const Bar& bar : drawing_.bars) write_bar(bar, taken);
    write_materials();
    close();
    write_meshes();
    return std::move(text_);
  }

 private:
  void line(const std::string& text) {
    text_.append(4 * depth_, ' ');
    text_ += text + '\n';
  }
  /// `has_material`: a material is bound to it. `reference`: a prim whose attributes it has; empty: none.
  void open(const std::string& type, const std::string& name, const std::string& shown, bool has_material = false,
            const std::string& reference = {}) {
    line("def " + type + " \"" + name + "\" (");
    if (!reference.empty()) line("    prepend references = <" + reference + ">");
    if (has_material) line("    prepend apiSchemas = [\"MaterialBindingAPI\"]");
    if (name != shown) line("    displayName = " + usd_string(shown));
    line(")");
    line("{");
    ++depth_;
  }
  void close() {
    --depth_;
    line("}");
  }

  /// An identifier that is not taken yet.
  static std::string identifier(const std::string& name, std::set<std::string>& taken) {
    std::string wanted;
    for (const char c : name) wanted += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ? c : '_';
    if (wanted.empty() || (wanted.front() >= '0' && wanted.front() <= '9')) wanted.insert(0, "_");
    std::string free = wanted;
    for (int n = 2; !taken.insert(free).second; ++n) free = wanted + "_" + std::to_string(n);
    return free;
  }

  double code_of(double time) const { return codes_per_second * std::max(time - drawing_.times.front(), 0.0); }

  /// Values that are the same throughout are no samples.
  void write_samples(const std::string& attribute, const Samples& samples) {
    const bool constant =
        std::all_of(samples.begin(), samples.end(), [&](const auto& s) { return s.second == samples[0].second; });
    if (constant) {
      line(attribute + " = " + samples[0].second);
      return;
    }
    line(attribute + ".timeSamples = {");
    for (const auto& [code, value] : samples) line("    " + number_text(code) + ": " + value + ",");
    line("}");
  }

  /// Of values that are interpolated, so that they change in steps.
  static Samples in_steps(const Samples& values) {
    Samples samples;
    for (const auto& [code, value] : values) {
      if (!samples.empty()) samples.emplace_back(std::nextafter(code, 0), samples.back().second);
      samples.emplace_back(code, value);
    }
    return samples;
  }

  void write_header() {
    std::vector<double> times;
    for (const RecordedEvent& event : drawing_.run.events) times.push_back(event.time - drawing_.times.front());
    text_ = "#usda 1.0\n";
    line("(");
    ++depth_;
    line("customLayerData = {");
    ++depth_;
    line("string momentree = " + usd_string(MOMENTREE_VERSION));
    line("double start = " + number_text(drawing_.times.front()));
    if (!drawing_.status.empty()) line("string status = " + usd_string(drawing_.status));
    const auto& events = drawing_.run.events;
    line("double[] event_times = [" + listed(times, [](double time) { return number_text(time); }) + "]");
    line("string[] events = [" + listed(events, [](const RecordedEvent& event) { return usd_string(event.name); }) + "]");
    line("string[] event_actions = [" +
         listed(events,
                [](const RecordedEvent& e) { return usd_string(listed(e.actions, [](const std::string& a) { return a; })); }) +
         "]");
    --depth_;
    line("}");
    line("defaultPrim = \"world\"");
    if (!drawing_.run.title.empty()) line("doc = " + usd_string(drawing_.run.title));
    line("endTimeCode = " + number_text(rows_.back().first));
    line("framesPerSecond = " + number_text(codes_per_second));
    line("metersPerUnit = 1");
    line("startTimeCode = 0");
    line("timeCodesPerSecond = " + number_text(codes_per_second));
    line("upAxis = \"Z\"");
    --depth_;
    line(")");
  }

  void write_body(std::size_t b, std::set<std::string>& taken) {
    const std::string name = identifier(drawing_.run.bodies[b].name, taken);
    Samples places, turns;
    for (const auto& [code, row] : rows_) {
      const double* const p = drawing_.pose(row, b);
      places.emplace_back(code, exact_tuple({p[0], p[1], p[2]}));
      turns.emplace_back(code, short_tuple(Quat{p[3], p[4], p[5], p[6]}));
    }
    open("Xform", name, drawing_.run.bodies[b].name);
    write_samples("double3 xformOp:translate", places);
    write_samples("quatf xformOp:orient", turns);
    line(R"(uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"])");
    Samples colours;
    for (const Colouring& colouring : drawing_.colourings) {
      const std::string colour = Drawing::colour_of(colouring.mechanism[b]);
      const double code = code_of(colouring.from);
      if (!colours.empty() && code <= colours.back().first)
        colours.back().second = colour;
      else if (colours.empty() || colours.back().second != colour)
        colours.emplace_back(code, colour);
    }
    std::set<std::string> below;
    for (const Solid& solid : drawing_.solids[b])
      write_solid(solid, solid.colour.empty() ? colours : Samples{{0, solid.colour}}, below);
    close();
  }

  void write_extent(const Vec3& low, const Vec3& high) {
    line("float3[] extent = [" + short_tuple(low) + ", " + short_tuple(high) + "]");
  }

  /// Those that solids refer to, written once.
  void write_meshes() {
    if (meshes_.empty()) return;
    line("class \"meshes\"");
    line("{");
    ++depth_;
    for (const int mesh : meshes_) {
      line("def Mesh \"" + mesh_name(mesh) + "\"");
      line("{");
      ++depth_;
      write_mesh(drawing_.run.mesh_parts[static_cast<std::size_t>(mesh)]);
      close();
    }
    close();
  }

  static std::string mesh_name(int mesh) { return "mesh_" + std::to_string(mesh); }

  void write_mesh(const MeshPart& part) {
    Vec3 low = part.points.front(), high = low;
    for (const Vec3& p : part.points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    write_extent(low, high);
    line("int[] faceVertexCounts = [" + listed(part.triangles, [](const auto&) { return std::string("3"); }) + "]");
    line("int[] faceVertexIndices = [" +
         listed(part.triangles, [](const auto& t) { return listed(t, [](std::uint32_t i) { return std::to_string(i); }); }) +
         "]");
    line("point3f[] points = [" + listed(part.points, [](const Vec3& p) { return short_tuple(p); }) + "]");
    line("uniform token subdivisionScheme = \"none\"");
    line("uniform bool doubleSided = true");  // it may be open
  }

  /// `colours`: from time codes on, "#rrggbb".
  void write_solid(const Solid& solid, const Samples& colours, std::set<std::string>& taken) {
    static constexpr const char* types[] = {"Cube", "Sphere", "Cylinder", "Capsule", "Mesh"};
    static constexpr const char* names[] = {"box", "ellipsoid", "cylinder", "capsule", "mesh"};
    const auto kind = static_cast<std::size_t>(solid.kind);
    const std::string name = identifier(names[kind], taken);
    std::string reference;
    if (solid.kind == Solid::Kind::mesh) {
      meshes_.insert(solid.mesh);
      reference = "/meshes/" + mesh_name(solid.mesh);
    }
    open(types[kind], name, name, true, reference);
    write_geometry(solid);
    write_colours(colours);
    line("double3 xformOp:translate = " + exact_tuple(solid.at.position));
    line("quatf xformOp:orient = " + short_tuple(solid.at.rotation));
    const bool capsule = solid.kind == Solid::Kind::capsule;
    line("float3 xformOp:scale = " + short_tuple(capsule ? Vec3{1, 1, 1} : solid.size));
    line(all_operations);
    close();
  }

  void write_geometry(const Solid& solid) {
    const double radius = 0.5 * solid.size.x;
    switch (solid.kind) {
      case Solid::Kind::box: line("double size = 1"); break;
      case Solid::Kind::ellipsoid: line("double radius = 0.5"); break;
      case Solid::Kind::cylinder:
        line("uniform token axis = \"Z\""), line("double height = 1"), line("double radius = 0.5");
        break;
      case Solid::Kind::capsule:
        line("uniform token axis = \"Z\"");
        line("double height = " + number_text(solid.size.z));
        line("double radius = " + number_text(radius));
        write_extent({-radius, -radius, -radius - 0.5 * solid.size.z}, {radius, radius, radius + 0.5 * solid.size.z});
        return;
      case Solid::Kind::mesh: return;  // in the prim to which it refers
    }
    write_extent({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  }

  void write_colours(const Samples& colours) {
    const auto [entry, fresh] = materials_.try_emplace(colours, "look_" + std::to_string(materials_.size() + 1));
    Samples arrays;
    for (const auto& [code, colour] : colours) arrays.emplace_back(code, "[" + usd_colour(colour) + "]");
    write_samples("color3f[] primvars:displayColor", in_steps(arrays));
    line("rel material:binding = </world/materials/" + entry->second + ">");
  }

  void write_materials() {
    open("Scope", "materials", "materials");
    for (const auto& [colours, name] : materials_) {
      const std::string shader = "/world/materials/" + name + "/shader";
      open("Material", name, name);
      line("token outputs:surface.connect = <" + shader + ".outputs:surface>");
      open("Shader", "shader", "shader");
      line("uniform token info:id = \"UsdPreviewSurface\"");
      Samples values;
      for (const auto& [code, colour] : colours) values.emplace_back(code, usd_colour(colour));
      write_samples("color3f inputs:diffuseColor", in_steps(values));
      line("float inputs:roughness = 0.6");
      line("token outputs:surface");
      close();
      close();
    }
    close();
  }

  void write_bar(const Bar& bar, std::set<std::string>& taken) {
    const std::string name = identifier(bar.name, taken);
    Samples places, turns, scales;
    BarPoses poses;
    for (const auto& [code, row] : rows_) {
      const Vec3 from = drawing_.place(row, bar.from, bar.from_point), to = drawing_.place(row, bar.to, bar.to_point);
      const Pose pose = poses.next(from, to);
      places.emplace_back(code, exact_tuple(pose.position));
      turns.emplace_back(code, short_tuple(pose.rotation));
      scales.emplace_back(code, short_tuple(bar_scale(bar.radius, from, to)));
    }
    Samples shown{{0, "\"invisible\""}};
    const auto show = [&](double time, const char* state) {
      const double code = code_of(time);
      if (code <= shown.back().first)
        shown.back().second = state;
      else
        shown.emplace_back(code, state);
    };
    show(bar.begin, "\"inherited\"");
    if (bar.end < 1e300) show(bar.end, "\"invisible\"");
    open("Cylinder", name, bar.name, true);
    write_geometry({.kind = Solid::Kind::cylinder});
    write_colours({{0, bar.colour}});
    write_samples("token visibility", shown);
    write_samples("double3 xformOp:translate", places);
    write_samples("quatf xformOp:orient", turns);
    write_samples("float3 xformOp:scale", scales);
    line(all_operations);
    close();
  }

  static constexpr const char* all_operations =
      R"(uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient", "xformOp:scale"])";

  const Drawing& drawing_;
  std::string text_;
  std::size_t depth_ = 0;
  std::vector<std::pair<double, std::size_t>> rows_;  ///< time codes, and the rows there
  std::map<Samples, std::string> materials_;          ///< by their colours from time codes on
  std::set<int> meshes_;                              ///< those that solids refer to
};

std::string usd_of(const Drawing& drawing) { return UsdBuilder(drawing).build(); }

}  // namespace

Exporter exporters::usd() {
  return {.ending = ".usda", .format = "USD", .content = "USD", .readers = "3D programs", .bytes = &usd_of};
}

}  // namespace momentree::io
