// <tendon>: a <spatial> tendon between two sites is a spring between two points, or a cable.
#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

void read_site(XmlElement element, const std::string& childclass, const std::string& body_name, int body, Reading& reading) {
  const auto name = element.find("name");
  if (!name) return;  // nothing can refer to it
  Attributes attributes(element, childclass, reading);
  // With `fromto` a site is at the middle of the segment.
  Vec3 point = attributes.vec3("pos").value_or(Vec3{});
  if (const auto ends = attributes.has("fromto") ? attributes.numbers("fromto", 6) : std::nullopt)
    point = 0.5 * Vec3{(*ends)[0] + (*ends)[3], (*ends)[1] + (*ends)[4], (*ends)[2] + (*ends)[5]};
  const std::string key(element.attribute(*name));
  const auto [first, fresh] = reading.sites.emplace(key, Reading::Site{element, childclass, body_name, {{body}, point}});
  if (!fresh)
    reading.file_of(element).error({element, *name}, "duplicate site " + in_quotes(key) +
                                                         ": the name is already used by another on " +
                                                         reading.file_of(first->second.element).line_of(first->second.element));
}

namespace {

// The sites of the path of a tendon; nothing if it has other elements, with a report.
std::optional<std::vector<XmlElement>> path_of(XmlElement tendon, const std::string& name, Reading& reading) {
  std::vector<XmlElement> sites;
  for (const XmlElement child : children_of(tendon, reading)) {
    if (child.name() == "site") {
      sites.push_back(child);
      continue;
    }
    reading.file_of(child).warning({child},
                                   "tendon " + in_quotes(name) + " is left out: its path has " +
                                       (child.name() == "geom"     ? "a geom around which it wraps"
                                        : child.name() == "pulley" ? "a pulley"
                                                                   : child.tag()),
                                   "only a straight tendon between two sites is a spring here");
    return std::nullopt;
  }
  if (sites.size() == 2) return sites;
  reading.file_of(tendon).warning({tendon},
                                  "tendon " + in_quotes(name) + " is left out: its path has " + std::to_string(sites.size()) +
                                      (sites.size() == 1 ? " site" : " sites"),
                                  "only a straight tendon between two sites is a spring here");
  return std::nullopt;
}

std::optional<SpringEnd> end_at(XmlElement element, Reading& reading) {
  XmlFields fields(element, reading.file_of(element));
  fields.require("site", "the name of a <site> in a body");
  const auto name = fields.string("site");
  if (!name) return std::nullopt;
  const auto found = reading.sites.find(*name);
  if (found != reading.sites.end()) return found->second.end;
  std::vector<std::string> known;
  for (const auto& [each, site] : reading.sites) known.push_back(each);
  std::sort(known.begin(), known.end());
  reading.file_of(element).error(fields.location("site"), "site: there is no site " + in_quotes(*name),
                                 did_you_mean(*name, known));
  return std::nullopt;
}

// Length of the tendon in the pose of the file.
double length_of(const Spring& spring, const std::vector<BodySpec>& bodies) {
  return norm(start_place(bodies, spring.to) - start_place(bodies, spring.from));
}

void read_spatial(XmlElement element, const std::vector<BodySpec>& bodies, Reading& reading) {
  XmlFile& file = reading.file_of(element);
  Attributes attributes(element, "", reading);
  ImportedSpring read;
  read.file = &file, read.element = element;
  Spring& spring = read.spring;
  const auto own = element.find("name");
  spring.name = own ? std::string(element.attribute(*own)) : "tendon" + std::to_string(reading.import.model.springs.size() + 1);
  if (own && !check_name(spring.name, {element, *own}, "a tendon", file)) return;
  const auto path = path_of(element, spring.name, reading);
  if (!path) return;
  const auto from = end_at((*path)[0], reading), to = end_at((*path)[1], reading);
  if (!from || !to) return;
  spring.from = *from, spring.to = *to;
  spring.stiffness = attributes.not_negative("stiffness").value_or(0);
  spring.damping = attributes.not_negative("damping").value_or(0);
  const auto ignored = [&](const char* name, const std::string& why) {
    file.warning(attributes.at(name), "tendon " + in_quotes(spring.name) + ": " + name + " is ignored", why);
  };
  const bool exerts = spring.stiffness != 0 || spring.damping != 0;
  if (attributes.has("range") && attributes.string("limited").value_or("auto") != "false") {
    const auto range = attributes.numbers("range", 2);
    // One that can only be too long is a cable.
    if (range && !exerts && (*range)[0] <= 0 && (*range)[1] > 0)
      spring.inextensible = true, spring.rest = (*range)[1];
    else
      ignored("range", exerts ? "a [[cable]] beside the spring holds its ends" : "a cable has no shortest length");
  }
  for (const char* name : {"frictionloss", "armature"})
    if (const auto value = attributes.number(name); value && *value != 0) ignored(name, "");
  if (!exerts && !spring.inextensible)
    return file.once(Severity::note, "a tendon without stiffness and damping is left out: it exerts no force", "", {element});
  const auto length = attributes.numbers("springlength", 1, 2);
  const double lower = length ? (*length)[0] : -1, upper = length ? length->back() : -1;
  if (spring.inextensible) {
    // The springlength of a tendon without stiffness has no effect.
  } else if (lower == upper) {
    spring.rest = lower < 0 ? length_of(spring, bodies) : lower;  // −1: as in the pose of the file
  } else if (lower == 0 && upper > 0) {
    spring.rest = upper, spring.tension_only = true;
    if (spring.damping > 0)
      file.once(Severity::note, "the damping of a tendon that can be slack acts only while it is taut", "", {element});
  } else {
    return file.warning(
        attributes.at("springlength"),
        "tendon " + in_quotes(spring.name) + " is left out: there is no force between the two lengths of springlength",
        "springlength=\"0 LENGTH\" is a rope, and one number a spring");
  }
  for (const SpringProblem& problem : check_spring(spring))
    return file.warning({element}, "tendon " + in_quotes(spring.name) + " is left out: " + problem.field + " " + problem.what,
                        problem.hint);
  const auto same = [&](const ImportedSpring& other) { return other.spring.name == spring.name; };
  auto& springs = reading.import.model.springs;
  if (const auto first = std::find_if(springs.begin(), springs.end(), same); first != springs.end())
    return file.error({element, own.value_or(XmlLocation::no_attribute)}, "duplicate tendon " + in_quotes(spring.name) +
                                                                              ": the name is already used by another on " +
                                                                              first->file->line_of(first->element));
  springs.push_back(std::move(read));
}

}  // namespace

void read_tendons(XmlElement tendon, Reading& reading) {
  std::vector<BodySpec> bodies;
  for (const XmlElement each : children_of(tendon, reading)) {
    if (reading.file_of(each).enough()) return;
    if (each.name() != "spatial") {
      reading.file_of(each).once(Severity::note, each.tag() + " in <tendon> is ignored", "", {each});
      continue;
    }
    if (bodies.empty())
      for (const ImportedBody& body : reading.import.model.bodies) bodies.push_back(body.spec);
    read_spatial(each, bodies, reading);
  }
}

}  // namespace momentree::io::mjcf
