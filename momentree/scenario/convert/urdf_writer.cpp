#include <momentree/scenario/convert/urdf_writer.hpp>

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include <momentree/text/colour.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io::urdf {

namespace {

std::string number(double x) { return number_text(x == 0 ? 0.0 : x); }
std::string three(const Vec3& a) { return number(a.x) + " " + number(a.y) + " " + number(a.z); }
bool is_zero(const Vec3& a) { return a.x == 0 && a.y == 0 && a.z == 0; }

void write_origin(std::string& text, const char* indent, const Pose& pose) {
  const Vec3 rpy = document_values::rpy_of(pose.rotation).angles;
  if (is_zero(pose.position) && is_zero(rpy)) return;
  text += indent;
  text += "<origin xyz=\"" + three(pose.position) + '"';
  if (!is_zero(rpy)) text += " rpy=\"" + three(rpy) + '"';
  text += "/>\n";
}

// Three decimals resolve all 255 levels.
std::string rgba(const std::string& colour) {
  std::string text;
  for (std::size_t i = 1; i < 7; i += 2) {
    int level = 0;
    std::from_chars(colour.data() + i, colour.data() + i + 2, level, 16);
    text += number(std::round(1000.0 * level / 255) / 1000) + " ";
  }
  return text + "1";
}

void write_visual(std::string& text, const Pose& at, const std::string& geometry, const std::string& colour) {
  text += "    <visual>\n";
  write_origin(text, "      ", at);
  text += "      <geometry>" + geometry + "</geometry>\n";
  if (const std::string value = hex_colour(colour); !value.empty())
    text += "      <material name=\"" + escaped(colour) + "\"><color rgba=\"" + rgba(value) + "\"/></material>\n";
  text += "    </visual>\n";
}

void write_shape(std::string& text, const Shape& shape) {
  const auto sphere = [&](double radius, double along_z) {
    write_visual(text, shape.at * Pose(0, 0, along_z), "<sphere radius=\"" + number(radius) + "\"/>", shape.colour);
  };
  const auto cylinder = [&](double radius, double length) {
    write_visual(text, shape.at, "<cylinder radius=\"" + number(radius) + "\" length=\"" + number(length) + "\"/>", shape.colour);
  };
  if (const auto* box = shape.as<contact::Box>())
    write_visual(text, shape.at, "<box size=\"" + three(box->size) + "\"/>", shape.colour);
  if (const auto* ball = shape.as<contact::Sphere>()) sphere(ball->radius, 0);
  if (const auto* round = shape.as<contact::Cylinder>()) cylinder(round->radius, round->length);
  if (const auto* capsule = shape.as<contact::Capsule>()) {  // few readers support <capsule>
    cylinder(capsule->radius, capsule->length);
    for (const double end : {0.5, -0.5}) sphere(capsule->radius, end * capsule->length);
  }
  if (shape.kind == Shape::Kind::mesh) {
    const Vec3& s = shape.scale;
    const bool scaled = s.x != 1 || s.y != 1 || s.z != 1;
    write_visual(text, shape.at,
                 "<mesh filename=\"" + escaped(shape.mesh) + '"' + (scaled ? " scale=\"" + three(s) + '"' : "") + "/>",
                 shape.colour);
  }
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  return out;
}

void write(std::string& text, const WrittenLink& link) {
  if (!link.comment.empty()) {
    std::string comment = link.comment;  // XML comments must not contain two dashes
    for (std::size_t i = 0; (i = comment.find("--", i)) != std::string::npos;) comment.insert(i + 1, " ");
    text += "  <!-- " + comment + " -->\n";
  }
  text += "  <link name=\"" + escaped(link.name) + '"';
  const Sym3& i = link.inertia;
  const bool inertial = link.mass != 0 || i.xx != 0 || i.yy != 0 || i.zz != 0;
  if (!inertial && link.shapes.empty()) {
    text += "/>\n";
    return;
  }
  text += ">\n";
  if (inertial) {
    text += "    <inertial>\n";
    write_origin(text, "      ", link.com);
    text += "      <mass value=\"" + number(link.mass) + "\"/>\n";
    text += "      <inertia ixx=\"" + number(i.xx) + "\" ixy=\"" + number(i.xy) + "\" ixz=\"" + number(i.xz) + "\" iyy=\"" +
            number(i.yy) + "\" iyz=\"" + number(i.yz) + "\" izz=\"" + number(i.zz) + "\"/>\n";
    text += "    </inertial>\n";
  }
  for (const Shape& shape : link.shapes) write_shape(text, shape);
  text += "  </link>\n";
}

void write(std::string& text, const WrittenJoint& joint) {
  text += "  <joint name=\"" + escaped(joint.name) + "\" type=\"" + joint.type + "\">\n";
  text += "    <parent link=\"" + escaped(joint.parent) + "\"/>\n";
  text += "    <child link=\"" + escaped(joint.child) + "\"/>\n";
  write_origin(text, "    ", joint.origin);
  if (joint.has_axis) text += "    <axis xyz=\"" + three(joint.axis) + "\"/>\n";
  // Readers require all of it, also effort and velocity without limits, and numbers for absent stops.
  constexpr double endless = 1e9;
  if (joint.type == "revolute" || joint.type == "prismatic")
    text += "    <limit lower=\"" + number(joint.stops ? std::fmax(joint.lower, -endless) : -endless) + "\" upper=\"" +
            number(joint.stops ? std::fmin(joint.upper, endless) : endless) + "\" effort=\"" +
            number(joint.effort > 0 ? joint.effort : endless) + "\" velocity=\"" + number(endless) + "\"/>\n";
  if (joint.damping != 0 || joint.friction != 0) {
    text += "    <dynamics";
    if (joint.damping != 0) text += " damping=\"" + number(joint.damping) + '"';
    if (joint.friction != 0) text += " friction=\"" + number(joint.friction) + '"';
    text += "/>\n";
  }
  text += "  </joint>\n";
}

}  // namespace momentree::io::urdf
