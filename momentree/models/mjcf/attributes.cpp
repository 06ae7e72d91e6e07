// Features common to all elements of MJCF: classes of defaults, orientations, includes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <momentree/base/error.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

double Compiler::angle(double given) const { return degrees ? given * std::numbers::pi / 180 : given; }

std::vector<XmlElement> children_of(XmlElement element, Reading& reading) {
  std::vector<XmlElement> children, open;
  for (const XmlElement child : element.children()) {
    if (child.name() != "include") {
      children.push_back(child);
      continue;
    }
    XmlFields fields(child, reading.file_of(child));
    fields.require("file", "for example <include file=\"arm.xml\"/>");
    const auto name = fields.string("file");
    fields.finish();
    if (!name) continue;
    const XmlElement root = reading.import.include(*name, fields.location("file"), reading.file_of(child));
    if (!root) continue;
    for (const XmlElement each : children_of(root, reading)) children.push_back(each);
  }
  return children;
}

Attributes::Attributes(XmlElement element, const std::string& childclass, Reading& reading)
    : element_(element), reading_(reading) {
  from_.push_back(element);
  std::string name = childclass.empty() ? reading.outermost : childclass;
  if (const auto own = element.find("class")) {
    name = element.attribute(*own);
    if (!reading.classes.contains(name)) {
      std::vector<std::string> known;
      for (const auto& [each, defaults] : reading.classes) known.push_back(each);
      std::sort(known.begin(), known.end());
      reading.file_of(element).error({element, *own}, "class: there is no default class " + in_quotes(name),
                                     did_you_mean(name, known));
      name = childclass.empty() ? reading.outermost : childclass;
    }
  }
  const std::string_view kind = element.name() == "spatial" ? "tendon" : element.name();  // as defaults call it
  for (int depth = 0; depth < 1000; ++depth) {
    const auto found = reading.classes.find(name);
    if (found == reading.classes.end()) break;
    const auto& parts = found->second.parts;
    for (auto part = parts.rbegin(); part != parts.rend(); ++part)
      if (part->name() == kind) from_.push_back(*part);
    if (found->second.parent.empty()) break;
    name = found->second.parent;
  }
}

XmlLocation Attributes::at(std::string_view name) const {
  for (const XmlElement each : from_)
    if (const auto i = each.find(name)) return {each, *i};
  return {};
}

void Attributes::error(std::string_view name, std::string what, std::string hint) {
  const XmlLocation location = at(name);
  const XmlElement place = location.element ? location.element : element_;
  reading_.file_of(place).error(location.element ? location : XmlLocation{element_}, std::move(what), std::move(hint));
}

std::optional<std::string> Attributes::string(std::string_view name) const {
  const XmlLocation location = at(name);
  if (!location.element) return {};
  return std::string(location.element.attribute(location.attribute));
}

std::optional<std::vector<double>> Attributes::numbers(std::string_view name, std::size_t count, std::size_t most) {
  const XmlLocation location = at(name);
  if (!location.element) return {};
  return read_numbers(location.element.attribute(location.attribute), count, most, location, name,
                      reading_.file_of(location.element));
}

std::optional<double> Attributes::number(std::string_view name) {
  const auto one = numbers(name, 1);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

std::optional<double> Attributes::not_negative(std::string_view name) {
  const auto value = number(name);
  if (!value || *value >= 0) return value;
  error(name, std::string(name) + ": must not be negative");
  return {};
}

std::optional<Vec3> Attributes::vec3(std::string_view name) {
  const auto three = numbers(name, 3);
  return three ? std::optional(Vec3{(*three)[0], (*three)[1], (*three)[2]}) : std::nullopt;
}

Quat Attributes::rotation() {
  const Compiler& compiler = reading_.compiler;
  const auto nothing = [&](const char* name) {
    error(name, std::string(name) + ": has no direction", "its length is zero, or two axes are parallel");
    return Quat{};
  };
  // Attributes of the element itself take precedence over those of its class.
  for (const XmlElement each : from_) {
    const auto given = [&](const char* name) { return each.find(name).has_value(); };
    if (given("quat")) {
      const auto q = numbers("quat", 4);
      if (!q) return {};
      const Quat quat{(*q)[0], (*q)[1], (*q)[2], (*q)[3]};
      const double length = std::hypot(std::hypot(quat.w, quat.x), std::hypot(quat.y, quat.z));
      if (length < 1e-9) return nothing("quat");
      return normalized(Quat{quat.w / length, quat.x / length, quat.y / length, quat.z / length});
    }
    if (given("axisangle")) {
      const auto a = numbers("axisangle", 4);
      if (!a) return {};
      const Vec3 axis{(*a)[0], (*a)[1], (*a)[2]};
      if (norm(axis) < 1e-9) return nothing("axisangle");
      return from_axis_angle(normalized(axis), compiler.angle((*a)[3]));
    }
    if (given("euler")) {
      const auto angles = vec3("euler");
      if (!angles) return {};
      const double turns[3] = {angles->x, angles->y, angles->z};
      Quat rotation{};
      for (std::size_t i = 0; i < 3; ++i) {
        const char c = compiler.eulerseq[i];
        const Vec3 axis = c == 'x' || c == 'X' ? Vec3{1, 0, 0} : c == 'y' || c == 'Y' ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
        const Quat turn = from_axis_angle(axis, compiler.angle(turns[i]));
        rotation = c >= 'a' ? rotation * turn : turn * rotation;  // lower case: axes that rotate with the body
      }
      return normalized(rotation);
    }
    if (given("xyaxes")) {
      const auto six = numbers("xyaxes", 6);
      if (!six) return {};
      const Vec3 x{(*six)[0], (*six)[1], (*six)[2]}, y{(*six)[3], (*six)[4], (*six)[5]};
      if (norm(x) < 1e-9 || norm(cross(x, y)) < 1e-9 * norm(x)) return nothing("xyaxes");
      const Vec3 a = normalized(x), b = normalized(y - dot(a, y) * a), c = cross(a, b);
      return quaternion_of({a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z});
    }
    if (given("zaxis")) {
      const auto z = vec3("zaxis");
      if (!z) return {};
      if (norm(*z) < 1e-9) return nothing("zaxis");
      const Vec3 a = normalized(*z);
      if (a.z < -1 + 1e-12) return {0, 1, 0, 0};
      return normalized(Quat{1 + a.z, -a.y, a.x, 0});
    }
  }
  return {};
}

Pose Attributes::pose() {
  const Vec3 position = vec3("pos").value_or(Vec3{});
  return {position, rotation()};
}

void check_attributes(XmlElement element, std::initializer_list<std::string_view> known, Reading& reading) {
  XmlFields fields(element, reading.file_of(element));
  fields.known(known);
  fields.known({"name", "class"});
  for (const XmlElement child : element.children()) fields.known_children({child.name()});
  fields.finish();
}

void read_compiler(XmlElement compiler, Reading& reading) {
  XmlFile& file = reading.file_of(compiler);
  XmlFields fields(compiler, file);
  Compiler& c = reading.compiler;
  const auto choice = [&](const char* name, std::initializer_list<const char*> words) -> std::optional<std::size_t> {
    const auto text = fields.string(name);
    if (!text) return {};
    std::string all;
    std::size_t i = 0;
    for (const char* word : words) {
      if (*text == word) return i;
      all += (i++ == 0 ? "" : ", ") + std::string(word);
    }
    file.error(fields.location(name), std::string(name) + ": expected one of " + all + ", found " + in_quotes(*text));
    return {};
  };
  if (const auto angle = choice("angle", {"degree", "radian"})) c.degrees = *angle == 0;
  if (const auto limits = choice("autolimits", {"false", "true"})) c.autolimits = *limits == 1;
  if (const auto balance = choice("balanceinertia", {"false", "true"})) c.balanceinertia = *balance == 1;
  if (const auto from = choice("inertiafromgeom", {"auto", "true", "false"}))
    c.from_geoms = static_cast<Compiler::FromGeoms>(*from);
  if (const auto coordinate = choice("coordinate", {"local", "global"}); coordinate && *coordinate == 1)
    file.error(fields.location("coordinate"), "coordinates in the world's frame are not supported",
               "save the model in local coordinates");
  c.boundmass = fields.not_negative("boundmass").value_or(c.boundmass);
  c.boundinertia = fields.not_negative("boundinertia").value_or(c.boundinertia);
  c.settotalmass = fields.number("settotalmass").value_or(c.settotalmass);
  if (const auto range = fields.numbers("inertiagrouprange", 2)) {
    c.first_group = static_cast<int>(std::clamp((*range)[0], -1e6, 1e6));
    c.last_group = static_cast<int>(std::clamp((*range)[1], -1e6, 1e6));
  }
  if (const auto sequence = fields.string("eulerseq")) {
    const auto fits = [](char letter) { return std::string_view("xyzXYZ").find(letter) != std::string_view::npos; };
    if (sequence->size() == 3 && std::all_of(sequence->begin(), sequence->end(), fits))
      c.eulerseq = *sequence;
    else
      file.error(fields.location("eulerseq"),
                 "eulerseq: expected three of the letters x, y, z, X, Y, Z, found " + in_quotes(*sequence));
  }
  c.meshdir = fields.string("meshdir").value_or(fields.string("assetdir").value_or(c.meshdir));
  c.strippath = fields.string("strippath").value_or(c.strippath ? "true" : "") == "true";
  fields.known({"texturedir", "fitaabb", "discardvisual", "usethread", "fusestatic", "convexhull", "exactmeshinertia",
                "alignfree", "saveinertial"});
  fields.known_children({"lengthrange"});
  fields.finish();
}

void read_defaults(XmlElement defaults, const std::string& parent, Reading& reading, int depth) {
  XmlFile& file = reading.file_of(defaults);
  std::string name = parent.empty() ? "main" : "";
  if (const auto own = defaults.find("class")) name = defaults.attribute(*own);
  if (parent.empty()) reading.outermost = name;
  if (name.empty()) {
    file.error({defaults}, "<default> within <default> has no 'class'", "give it a name");
    return;
  }
  if (depth > 100) return file.error({defaults}, "classes of defaults are nested more than 100 deep");
  const auto [found, fresh] = reading.classes.emplace(name, Reading::Class{defaults, {}, parent});
  if (!fresh && !parent.empty()) {
    const XmlElement first = found->second.element;
    file.error({defaults}, "duplicate default class " + in_quotes(name) + ": the name is already used by another on " +
                               reading.file_of(first).line_of(first));
    return;
  }
  std::vector<XmlElement> parts = found->second.parts, inner;
  for (const XmlElement child : children_of(defaults, reading)) (child.name() == "default" ? inner : parts).push_back(child);
  if (parts.size() > 200) return file.error({defaults}, "a class of more than 200 defaults");
  found->second.parts = std::move(parts);
  for (const XmlElement child : inner) read_defaults(child, name, reading, depth + 1);
}

}  // namespace momentree::io::mjcf
