// Elements that contain text, poses and names.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <momentree/base/error.hpp>
#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

XmlElement Texts::leaf(std::string_view child) {
  const XmlElement element = fields.child(child);
  if (!element) return element;
  spot_ = {element, XmlLocation::no_attribute, true};
  XmlFields(element, file_).finish();
  return element;
}

std::optional<std::string> Texts::string(std::string_view child) {
  const XmlElement element = leaf(child);
  return element ? std::optional(std::string(element.text())) : std::nullopt;
}

std::optional<double> Texts::number(std::string_view child) {
  const XmlElement element = leaf(child);
  if (!element) return {};
  const auto one = read_numbers(element.text(), 1, 1, spot_, child, file_);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

std::optional<double> Texts::not_negative(std::string_view child) {
  const auto value = number(child);
  if (!value || *value >= 0) return value;
  file_.error(spot_, std::string(child) + ": must not be negative");
  return {};
}

std::optional<double> Texts::bound(std::string_view child) {
  const XmlElement element = leaf(child);
  if (!element) return {};
  std::string_view text = element.text();
  constexpr double inf = std::numeric_limits<double>::infinity();
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text == "inf" || text == "Inf" || text == "INF" || text == "infinity") return negative ? -inf : inf;
  const auto one = read_numbers(element.text(), 1, 1, spot_, child, file_);
  if (!one) return {};
  return std::fabs((*one)[0]) >= 1e16 ? std::copysign(inf, (*one)[0]) : (*one)[0];  // the value that older versions used for it
}

std::optional<Vec3> Texts::vec3(std::string_view child) {
  const XmlElement element = leaf(child);
  if (!element) return {};
  const auto three = read_numbers(element.text(), 3, 3, spot_, child, file_);
  return three ? std::optional(Vec3{(*three)[0], (*three)[1], (*three)[2]}) : std::nullopt;
}

std::optional<bool> Texts::boolean(std::string_view child) {
  const XmlElement element = leaf(child);
  if (!element) return {};
  std::string text(element.text());
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  file_.error(spot_, std::string(child) + ": expected true or false, found " + in_quotes(element.text()));
  return {};
}

namespace {

Quat rotation_of(const std::vector<double>& numbers, bool quaternion, bool degrees, const XmlLocation& location, XmlFile& file) {
  if (!quaternion) {
    const double unit = degrees ? std::numbers::pi / 180 : 1;
    return from_rpy(unit * numbers[3], unit * numbers[4], unit * numbers[5]);
  }
  const Quat given{numbers[6], numbers[3], numbers[4], numbers[5]};
  const double length = std::hypot(std::hypot(given.w, given.x), std::hypot(given.y, given.z));
  if (std::fabs(length - 1) <= 1e-3) return normalized(given);
  file.error(location, "pose: the length of the quaternion is not 1", "the order is x y z qx qy qz qw");
  return {};
}

}  // namespace

FramedPose read_pose(XmlFields& fields, Version version, XmlFile& file) {
  FramedPose result;
  const XmlElement pose = fields.child("pose");
  if (!pose) return result;
  XmlFields of(pose, file);
  result.location = {pose, XmlLocation::no_attribute, true};
  // The attribute's name until 1.6; newer versions use another.
  const char* key = version.frames() ? "relative_to" : "frame";
  const char* other = version.frames() ? "frame" : "relative_to";
  if (of.string(other).value_or("") != "")
    file.error(of.location(other),
               "pose: '" + std::string(other) + "' is '" + key + "' in SDF 1." + std::to_string(version.minor),
               "write " + std::string(key) + "=…");
  result.relative_to = of.string(key).value_or("");
  if (!result.relative_to.empty()) result.location = of.location(key);
  const bool degrees = of.boolean("degrees").value_or(false);
  const std::string format = of.string("rotation_format").value_or("euler_rpy");
  const bool quaternion = format == "quat_xyzw";
  if (!quaternion && format != "euler_rpy")
    file.error(of.location("rotation_format"), "rotation_format: expected euler_rpy or quat_xyzw, found " + in_quotes(format));
  if (quaternion && degrees) file.error(of.location("degrees"), "pose: a quaternion has no degrees", "leave 'degrees' out");
  of.finish();
  if (pose.text().empty()) return result;
  const XmlLocation text{pose, XmlLocation::no_attribute, true};
  const std::size_t count = quaternion ? 7 : 6;
  const auto numbers = read_numbers(pose.text(), count, count, text, "pose", file);
  if (!numbers) return result;
  result.pose.position = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
  result.pose.rotation = rotation_of(*numbers, quaternion, degrees, text, file);
  return result;
}

std::string read_name(XmlFields& fields, const char* what, Version version, XmlFile& file) {
  if (!fields.require("name", "for example name=\"upper_arm\"")) return {};
  const std::string name = fields.string("name").value_or("");
  const XmlLocation location = fields.location("name");
  if (!check_name(name, location, what, file)) return {};
  const auto refuse = [&](const std::string& why, const std::string& hint) {
    file.error(location, "name: " + std::string(what) + " cannot be named " + in_quotes(name) + ": " + why, hint);
    return std::string{};
  };
  if (name == "world" || (name.size() > 3 && name.starts_with("__") && name.ends_with("__")))
    return refuse("the format reserves that name", "");
  if (version.minor >= 8 && name.find("::") != std::string::npos)
    return refuse("'::' separates the names of a model and its parts", "");
  return name;
}

}  // namespace momentree::io::sdf
