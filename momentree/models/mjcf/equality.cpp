// <equality>: connect and weld are joints that close loops, joint is a joint that follows another.
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/model/start.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

namespace {

/// A frame on a body, or in the world.
struct End {
  int body = -1;
  Pose at{};
};

class EqualityReader {
 public:
  explicit EqualityReader(Reading& reading) : reading_(reading), model_(reading.import.model) {
    for (const ImportedBody& body : model_.bodies) {
      const BodySpec& spec = body.spec;
      const Values q = start_coordinates(spec);
      const Pose parent = spec.parent == ground ? Pose{} : placed_[static_cast<std::size_t>(spec.parent.index)];
      JointSpec joint = spec.joint;
      if (info(joint.kind).axis) joint.axis = normalized(joint.axis);
      placed_.push_back(parent * spec.at * joint_motion(joint, q.begin()) * inverse(spec.child_at));
      const int number = static_cast<int>(placed_.size()) - 1;
      if (body.spots.body.name() == "body") bodies_.emplace(spec.name, number);
      joints_.emplace(spec.joint_name, number);
    }
  }

  void read(XmlElement each) {
    XmlFile& file = reading_.file_of(each);
    const std::string_view tag = each.name();
    if (!is_active(each))
      return file.once(Severity::note, each.tag() + " in <equality> is left out: it is not active", "", {each});
    for (const char* soft : {"solref", "solimp", "torquescale"})
      if (const auto i = each.find(soft))
        file.once(Severity::note, std::string(soft) + " in <equality> is ignored", "loops are closed exactly", {each, *i});
    if (tag == "connect" || tag == "weld")
      close(each, tag == "weld");
    else if (tag == "joint")
      follow(each);
    else
      file.once(Severity::warning, each.tag() + " in <equality> is left out: connect, weld and joint are read", "", {each});
  }

 private:
  // Also as a default for all kinds of equality.
  bool is_active(XmlElement each) {
    if (const auto own = each.find("active")) return each.attribute(*own) != "false";
    std::string name = reading_.outermost;
    if (const auto own = each.find("class")) name = each.attribute(*own);
    for (int depth = 0; depth < 1000; ++depth) {
      const auto found = reading_.classes.find(name);
      if (found == reading_.classes.end()) break;
      const auto& parts = found->second.parts;
      for (auto part = parts.rbegin(); part != parts.rend(); ++part)
        if (const auto given = part->find("active"); given && part->name() == "equality")
          return part->attribute(*given) != "false";
      if (found->second.parent.empty()) break;
      name = found->second.parent;
    }
    return true;
  }

  Pose placed(int body) const { return body < 0 ? Pose{} : placed_[static_cast<std::size_t>(body)]; }

  template <class Names>
  void unknown(const char* what, const std::string& name, const XmlLocation& at, const Names& names) {
    XmlFile& file = reading_.file_of(at.element);
    std::vector<std::string> known;
    if (names.size() <= 10'000 && file.may_suggest())
      for (const auto& [each, value] : names) known.push_back(each);
    std::sort(known.begin(), known.end());
    file.error(at, std::string("there is no ") + what + " " + in_quotes(name), did_you_mean(name, known));
  }

  // The body, −1: the world; nothing, with a report, if there is none.
  std::optional<int> body_of(XmlFields& fields, const char* key) {
    const auto name = fields.string(key);
    if (!name || *name == "world") return -1;
    if (const auto found = bodies_.find(*name); found != bodies_.end()) return found->second;
    unknown("body", *name, fields.location(key), bodies_);
    return {};
  }

  std::optional<End> site_of(XmlFields& fields, const char* key) {
    const auto name = fields.string(key);
    if (!name) return {};
    const auto found = reading_.sites.find(*name);
    if (found == reading_.sites.end()) {
      unknown("site", *name, fields.location(key), reading_.sites);
      return {};
    }
    const auto& [element, childclass, body, end] = found->second;
    Attributes attributes(element, childclass, reading_);
    if (attributes.has("fromto")) {
      attributes.error("fromto", "a site of <equality> is not placed by fromto here", "give it pos, and quat or the like");
      return {};
    }
    const auto carrier = bodies_.find(body);
    return End{carrier == bodies_.end() ? -1 : carrier->second, attributes.pose()};
  }

  void close(XmlElement each, bool weld) {
    XmlFields fields(each, reading_.file_of(each));
    fields.known({"name", "class", "active", "solref", "solimp", "torquescale"});
    const std::size_t errors = reading_.import.errors();
    std::optional<End> one, other;
    if (fields.has("site1") || fields.has("site2")) {
      fields.require("site1", "both ends are sites, or both are bodies");
      fields.require("site2", "both ends are sites, or both are bodies");
      one = site_of(fields, "site1"), other = site_of(fields, "site2");
    } else {
      fields.require("body1", "the name of a body, or two sites: site1 and site2");
      if (!weld) fields.require("anchor", "the point in the frame of body1, for example anchor=\"0 0 0.5\"");
      const auto first = body_of(fields, "body1"), second = body_of(fields, "body2");
      const Vec3 anchor = fields.vec3("anchor").value_or(Vec3{});
      const auto relative = weld ? fields.numbers("relpose", 7) : std::nullopt;
      if (first && second && errors == reading_.import.errors()) {
        const Pose between = inverse(placed(*first)) * placed(*second);
        if (weld) {
          one = End{*first, between * Pose(anchor)}, other = End{*second, Pose(anchor)};
          if (relative) set_relative(*relative, each, fields, one->at);
        } else {
          one = End{*first, Pose(anchor)}, other = End{*second, inverse(between) * Pose(anchor)};
        }
      }
    }
    fields.finish();
    const std::string name = name_of(each);
    if (!one || !other || errors != reading_.import.errors()) return;
    if (one->body == other->body)
      return reading_.file_of(each).error(
          {each}, each.tag() + " joins " + (one->body < 0 ? std::string("the world") : "a body") + " to itself");
    if (one->body < 0) std::swap(one, other);
    ImportedLoop& loop = model_.loops.emplace_back();
    loop.spec.name = name;
    loop.spec.body = {one->body}, loop.spec.to = {other->body};
    loop.spec.child_at = one->at, loop.spec.at = other->at;
    loop.spec.joint.kind = weld ? Kind::weld : Kind::ball;
    loop.spots = {&reading_.file_of(each), each, each, {}, {}};
  }

  // `relpose`: position and quaternion of the weld's frame in body1; a quaternion of zeros: as in the pose of the file.
  void set_relative(const std::vector<double>& r, XmlElement each, XmlFields& fields, Pose& at) {
    if (r[3] == 0 && r[4] == 0 && r[5] == 0 && r[6] == 0) return;
    const double length = std::hypot(std::hypot(r[3], r[4]), std::hypot(r[5], r[6]));
    if (length < 1e-9)
      return reading_.file_of(each).error(fields.location("relpose"), "relpose: the quaternion has no direction");
    at = {{r[0], r[1], r[2]}, normalized(Quat{r[3] / length, r[4] / length, r[5] / length, r[6] / length})};
  }

  // Names are unique among the equalities; those of joints are another list in the file, but not here.
  std::string name_of(XmlElement each) {
    XmlFile& file = reading_.file_of(each);
    std::string name;
    if (const auto given = each.find("name")) {
      name = each.attribute(*given);
      check_name(name, {each, *given}, "an equality", file);
      const auto [first, fresh] = given_.emplace(name, each);
      if (!fresh)
        file.error({each, *given}, "duplicate equality " + in_quotes(name) + ": the name is already used by another on " +
                                       reading_.file_of(first->second).line_of(first->second));
      while (joints_.contains(name) || used_.contains(name)) name += "~loop";
    } else {
      do name = "loop" + std::to_string(++unnamed_);
      while (joints_.contains(name) || used_.contains(name));
    }
    used_.insert(name);
    return name;
  }

  std::optional<int> joint_of(XmlFields& fields, const char* key) {
    const auto name = fields.string(key);
    if (!name) return {};
    const auto found = joints_.find(*name);
    if (found == joints_.end() || !reading_.joint_names.contains(*name)) {
      unknown("joint", *name, fields.location(key), reading_.joint_names);
      return {};
    }
    const BodySpec& spec = model_.bodies[static_cast<std::size_t>(found->second)].spec;
    if (info(spec.joint.kind).nv == 1) return found->second;
    reading_.file_of(fields.location(key).element)
        .error(fields.location(key),
               std::string(key) + ": joint " + in_quotes(*name) + " is a " + std::string(info(spec.joint.kind).name) + " joint",
               "it needs one degree of freedom");
    return {};
  }

  // y − y0 = a0 + a1 (x − x0): y0 and x0 are the coordinates in the pose of the file.
  void follow(XmlElement each) {
    XmlFile& file = reading_.file_of(each);
    XmlFields fields(each, file);
    fields.known({"name", "class", "active", "solref", "solimp"});
    fields.require("joint1", "the name of the joint that follows");
    const bool leads = fields.has("joint2");
    const auto joint = joint_of(fields, "joint1"), leader = joint_of(fields, "joint2");
    std::array<double, 5> a{0, 1, 0, 0, 0};
    if (const auto given = fields.numbers("polycoef", 1, 5)) std::copy(given->begin(), given->end(), a.begin());
    fields.finish();
    if (!joint || (leads && !leader)) return;
    if (leads && *joint == *leader)
      return file.error(fields.location("joint2"), "a joint cannot follow itself", "name another joint");
    const auto start = [this](int body) { return start_coordinates(model_.bodies[static_cast<std::size_t>(body)].spec)[0]; };
    if (!leads) return model_.followers.push_back({*joint, -1, 0, start(*joint) + a[0], &file, each, {}, true});
    // In powers of x instead of x − x0, by Horner's scheme for a shift.
    const double x0 = start(*leader);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 4; k-- > i;) a[k] -= x0 * a[k + 1];
    model_.followers.push_back({*joint, *leader, a[1], start(*joint) + a[0], &file, each, {a[2], a[3], a[4]}, true});
  }

  Reading& reading_;
  ImportedModel& model_;
  std::vector<Pose> placed_;  // of bodies in the pose of the file
  std::unordered_map<std::string, int> bodies_, joints_;
  std::unordered_map<std::string, XmlElement> given_;
  std::unordered_set<std::string> used_;
  int unnamed_ = 0;
};

}  // namespace

void read_equalities(const std::vector<XmlElement>& sections, Reading& reading) {
  EqualityReader reader(reading);
  for (const XmlElement section : sections)
    for (const XmlElement each : children_of(section, reading)) {
      reader.read(each);
      if (reading.file_of(each).enough()) return;
    }
}

}  // namespace momentree::io::mjcf
