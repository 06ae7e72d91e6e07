#include <cmath>
#include <numbers>

#include <momentree/base/error.hpp>
#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

namespace {

struct Type {
  const char* name;
  Kind kind;
  int axes;
  bool limited;
};
constexpr Type types[] = {{"revolute", Kind::revolute, 1, true},   {"continuous", Kind::revolute, 1, false},
                          {"prismatic", Kind::prismatic, 1, true}, {"fixed", Kind::weld, 0, false},
                          {"ball", Kind::ball, 0, false},          {"universal", Kind::universal, 2, true},
                          {"revolute2", Kind::universal, 2, true}, {"screw", Kind::helical, 1, true}};

const Type* read_type(XmlFields& fields, XmlFile& file) {
  if (fields.string("type") == "gearbox") {
    file.error(fields.location("type"), "a gearbox couples two joints, which is not supported yet",
               "leave it out: the joints then move independently");
    return nullptr;
  }
  std::vector<std::string> names;
  for (const Type& type : types) names.emplace_back(type.name);
  const int place = fields.require_choice("type", names, "type of joint");
  return place < 0 ? nullptr : &types[place];
}

std::string read_end(Texts& texts, const char* end, XmlLocation& location, XmlFile& file) {
  const auto name = texts.string(end);
  if (!name) {
    texts.fields.require_child(end, std::string("for example <") + end + ">base</" + end + ">");
    return {};
  }
  location = texts.location();
  if (name->empty()) file.error(location, std::string(end) + ": the name of a link is missing");
  return *name;
}

void read_limit(XmlElement element, const Type& type, AxisPart& axis, XmlFile& file) {
  Texts texts(element, file);
  constexpr double inf = std::numeric_limits<double>::infinity();
  const std::size_t errors = file.out().errors();
  const double lower = texts.bound("lower").value_or(-inf);
  const XmlLocation at = texts.fields.child("lower") ? texts.location() : XmlLocation{element};
  const double upper = texts.bound("upper").value_or(inf);
  const auto effort = texts.bound("effort");
  if (effort && *effort == 0)
    file.once(Severity::note, "an effort limit of 0: nothing could drive this joint", "efforts are not limited here",
              texts.location());
  texts.bound("velocity");
  texts.bound("stiffness");
  texts.bound("dissipation");
  texts.fields.finish();
  if (!type.limited || errors != file.out().errors()) return;
  if (lower > upper) {
    file.error(at, "limit: 'lower' is greater than 'upper'", "swap them");
  } else if (lower == upper) {
    file.once(Severity::warning, "the limits of this joint are equal: it could not move; they are ignored",
              "use type=\"fixed\" for a joint that does not move", {element});
  } else {
    axis.lower = lower;
    axis.upper = upper;
    axis.limit = element;
  }
}

void read_dynamics(XmlElement element, AxisPart& axis, XmlFile& file) {
  Texts texts(element, file);
  axis.damping = texts.not_negative("damping").value_or(0);
  axis.friction = texts.not_negative("friction").value_or(0);
  axis.rest = texts.number("spring_reference").value_or(0);
  axis.stiffness = texts.not_negative("spring_stiffness").value_or(0);
  texts.fields.finish();
}

AxisPart read_axis(XmlElement element, const Type& type, Version version, XmlFile& file) {
  AxisPart axis;
  axis.location = {element};
  Texts texts(element, file);
  if (const XmlElement xyz = texts.fields.child("xyz")) {
    axis.location = {xyz, XmlLocation::no_attribute, true};
    XmlFields of(xyz, file);
    if (version.frames()) axis.expressed_in = of.string("expressed_in").value_or("");
    of.finish();
    if (const auto given = read_numbers(xyz.text(), 3, 3, axis.location, "xyz", file))
      axis.xyz = {(*given)[0], (*given)[1], (*given)[2]};
    const double length = norm(axis.xyz);
    if (length < 1e-9) {
      file.error(axis.location, "xyz: an axis of length zero has no direction", "for example <xyz>0 0 1</xyz>");
      axis.xyz = {0, 0, 1};
    } else if (std::fabs(length - 1) > 1e-3) {
      file.once(Severity::note, "the length of an axis is not 1: only its direction is used", "", axis.location);
    }
  }
  // Until 1.4, axes are in the model's frame; until 1.6 optionally.
  if (version.minor <= 4) {
    axis.expressed_in = "__model__";
  } else if (!version.frames()) {
    if (texts.boolean("use_parent_model_frame").value_or(false)) axis.expressed_in = "__model__";
  }
  if (const XmlElement limit = texts.fields.child("limit")) read_limit(limit, type, axis, file);
  if (const XmlElement dynamics = texts.fields.child("dynamics")) read_dynamics(dynamics, axis, file);
  axis.mimic = texts.fields.child("mimic");
  texts.number("initial_position");
  texts.fields.finish();
  return axis;
}

void read_pitch(Texts& texts, JointPart& joint, XmlFile& file) {
  const auto old = texts.number("thread_pitch");
  const XmlLocation location = texts.location();
  const auto pitch = texts.number("screw_thread_pitch");
  if (joint.kind != Kind::helical) return;
  if (pitch) {
    joint.pitch = *pitch;
  } else if (old && *old == 0) {
    file.error(location, "thread_pitch: 0 rad/m is not a thread", "it is in rad/m, and positive for a left-handed thread");
  } else if (old) {
    joint.pitch = -2 * std::numbers::pi / *old;  // rad/m of a left-handed thread, which is how Gazebo reads it
  } else if (!texts.fields.child("thread_pitch") && !texts.fields.child("screw_thread_pitch")) {
    file.warning({joint.element}, "a screw without <screw_thread_pitch>: the format's default is 1 m per turn");
  }
}

}  // namespace

JointPart read_joint(XmlElement element, Version version, XmlFile& file) {
  JointPart joint;
  joint.element = element;
  Texts texts(element, file);
  XmlFields& fields = texts.fields;
  joint.name = read_name(fields, "a joint", version, file);
  joint.parent = read_end(texts, "parent", joint.parent_spot, file);
  joint.child = read_end(texts, "child", joint.child_spot, file);
  const Type* type = read_type(fields, file);
  joint.pose = read_pose(fields, version, file);
  if (type) {
    joint.known = true;
    joint.kind = type->kind;
    joint.dofs = type->axes;
  }
  read_pitch(texts, joint, file);
  constexpr const char* names[] = {"axis", "axis2"};
  for (int i = 0; i < 2; ++i) {
    if (!type || i >= type->axes) {
      fields.known_children({names[i]});  // meaningless there, but common
    } else if (const XmlElement axis = fields.require_child(
                   names[i], "for example <" + std::string(names[i]) + "><xyz>0 0 1</xyz></" + names[i] + ">")) {
      joint.axes[static_cast<std::size_t>(i)] = read_axis(axis, *type, version, file);
    }
  }
  fields.known_children({"gearbox_ratio", "gearbox_reference_body"});
  fields.leave_out({"physics", "sensor"}, "it belongs to another program");
  fields.finish();
  return joint;
}

}  // namespace momentree::io::sdf
