#include <cmath>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/models/urdf/parts.hpp>

namespace momentree::io::urdf {

namespace {

struct Type {
  const char* name;
  Kind kind;
  bool axis, limited;
};
constexpr Type types[] = {{"revolute", Kind::revolute, true, true},   {"continuous", Kind::revolute, true, false},
                          {"prismatic", Kind::prismatic, true, true}, {"fixed", Kind::weld, false, false},
                          {"floating", Kind::free, false, false},     {"planar", Kind::planar, true, false}};

const Type* read_type(XmlFields& fields) {
  std::vector<std::string> names;
  for (const Type& type : types) names.emplace_back(type.name);
  const int place = fields.require_choice("type", names, "type of joint");
  return place < 0 ? nullptr : &types[place];
}

std::string read_end(XmlFields& fields, const char* end, XmlLocation& location, XmlFile& file) {
  const XmlElement element = fields.require_child(end, std::string("for example <") + end + " link=\"base\"/>");
  if (!element) return {};
  XmlFields of(element, file);
  of.require("link", "the name of a link");
  const std::string name = usable_name(of.string("link").value_or(""));
  location = of.location("link");
  if (of.has("link") && name.empty()) file.error(location, std::string(end) + ": the name of a link is missing");
  of.finish();
  return name;
}

// The shortest rotation that takes z to `axis`.
Quat from_z_to(const Vec3& axis) {
  const Vec3 a = normalized(axis);
  if (a.z < -1 + 1e-12) return {0, 1, 0, 0};
  return normalized(Quat{1 + a.z, -a.y, a.x, 0});
}

Vec3 read_axis(XmlFields& fields, XmlFile& file) {
  const XmlElement element = fields.child("axis");
  Vec3 axis{1, 0, 0};  // default of the format
  if (!element) return axis;
  XmlFields of(element, file);
  of.require("xyz", "for example xyz=\"0 0 1\"");
  const auto given = of.vec3("xyz");
  const XmlLocation location = of.location("xyz");
  of.finish();
  if (!given) return axis;
  const double length = norm(*given);
  if (length < 1e-9) {
    file.error(location, "xyz: an axis of length zero has no direction", "for example xyz=\"0 0 1\"");
    return axis;
  }
  if (std::fabs(length - 1) > 1e-3)
    file.once(Severity::note, "the length of an axis is not 1: only its direction is used", "", location);
  return *given;
}

void read_limit(XmlElement limit, const Type& type, Joint& joint, XmlFile& file) {
  XmlFields fields(limit, file);
  const std::size_t errors = file.out().errors();
  const double lower = fields.number("lower").value_or(0), upper = fields.number("upper").value_or(0);
  const auto effort = fields.not_negative("effort");
  fields.not_negative("velocity");
  if (effort && *effort == 0)
    file.once(Severity::note, "an effort limit of 0: nothing could drive this joint", "efforts are not limited here",
              fields.location("effort"));
  fields.finish();
  if (errors != file.out().errors()) return;
  const bool given = fields.has("lower") || fields.has("upper");
  if (given && type.kind == Kind::revolute && !type.limited)
    file.once(Severity::note, "the limits of a continuous joint are not used: it turns without end",
              "use type=\"revolute\" for a joint with limits", {limit});
  if (!given && type.limited)
    file.once(Severity::warning,
              std::string("a ") + type.name + " joint whose <limit> has neither 'lower' nor 'upper': it is not limited",
              type.kind == Kind::revolute ? "use type=\"continuous\" for that" : "", {limit});
  if (!type.limited || !given) return;
  if (lower > upper) {
    file.error(fields.location("lower"), "limit: 'lower' is greater than 'upper'", "swap them");
  } else if (lower == upper) {
    file.once(Severity::warning, "the limits of this joint are equal: it could not move; they are ignored",
              "use type=\"fixed\" for a joint that does not move", {limit});
  } else {
    joint.lower = lower;
    joint.upper = upper;
    joint.limit = limit;
  }
}

void read_dynamics(XmlElement dynamics, const Type& type, Joint& joint, XmlFile& file) {
  XmlFields fields(dynamics, file);
  const double damping = fields.not_negative("damping").value_or(0), friction = fields.not_negative("friction").value_or(0);
  fields.finish();
  if (info(type.kind).nv == 0) return;
  joint.damping = damping;
  joint.friction = friction;
}

}  // namespace

Joint read_joint(XmlElement element, XmlFile& file) {
  Joint joint;
  XmlFields fields(element, file);
  joint.ends.element = element;
  if (fields.require("name", "for example name=\"elbow\"")) joint.ends.name = read_name(fields, "a joint", file);
  joint.ends.parent = read_end(fields, "parent", joint.ends.parent_spot, file);
  joint.ends.child = read_end(fields, "child", joint.ends.child_spot, file);
  const Type* type = read_type(fields);
  joint.at = read_origin(fields, file);
  Vec3 axis{1, 0, 0};
  if (type && !type->axis)
    fields.known_children({"axis"});  // meaningless there, but common: often xyz="0 0 0"
  else
    axis = read_axis(fields, file);
  const XmlElement limit = fields.child("limit"), dynamics = fields.child("dynamics");
  joint.mimic = fields.child("mimic");
  fields.leave_out({"calibration", "safety_controller"}, "it belongs to a controller");
  fields.finish();
  if (!type) return joint;
  joint.kind = type->kind;
  if (type->kind == Kind::planar) {
    joint.turn = from_z_to(axis);
    joint.at.rotation = joint.at.rotation * joint.turn;
  } else if (type->axis) {
    joint.axis = axis;
  }
  if (limit)
    read_limit(limit, *type, joint, file);
  else if (type->limited)
    file.once(Severity::warning, std::string("a ") + type->name + " joint without <limit>: it is not limited",
              type->kind == Kind::revolute ? "use type=\"continuous\" for that" : "", {element});
  if (dynamics) read_dynamics(dynamics, *type, joint, file);
  return joint;
}

}  // namespace momentree::io::urdf
