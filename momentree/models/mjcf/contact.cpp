// <contact>: pairs of bodies that never touch, and pairs of geoms that do whatever their masks are.
#include <algorithm>

#include <momentree/models/mjcf/parts.hpp>

namespace momentree::io::mjcf {

namespace {

void read_exclude(XmlElement exclude, Reading& reading) {
  const auto one = exclude.find("body1"), other = exclude.find("body2");
  if (one && other)
    reading.import.model.excluded.emplace_back(exclude.attribute(*one), exclude.attribute(*other));
  else
    reading.file_of(exclude).error({exclude}, "<exclude> names two bodies", "body1 and body2");
}

void read_pair(XmlElement pair, Reading& reading) {
  XmlFile& file = reading.file_of(pair);
  check_attributes(pair, {"geom1", "geom2", "condim", "friction", "solref", "solreffriction", "solimp", "margin", "gap"},
                   reading);
  Attributes attributes(pair, "", reading);
  const NamedGeom* ends[2] = {};
  for (int i = 0; i < 2; ++i) {
    const char* const key = i == 0 ? "geom1" : "geom2";
    const auto name = attributes.string(key);
    if (!name) return file.error({pair}, "<pair> names two geoms", "geom1 and geom2");
    const auto found = reading.geoms.find(*name);
    if (found == reading.geoms.end())
      return file.warning(attributes.at(key), "<pair> names " + in_quotes(*name) + ", which is no geom: ignored");
    ends[i] = &found->second;
  }
  if (ends[0]->body == ends[1]->body) return;
  ImportedPair touching{ends[0]->body, ends[1]->body, std::max(ends[0]->friction, ends[1]->friction)};
  if (const auto friction = attributes.numbers("friction", 1, 5)) {
    touching.friction = friction->front();
    if (friction->size() > 1 && (*friction)[1] != touching.friction)
      file.once(Severity::warning, different_friction, friction_hint, attributes.at("friction"));
  }
  if (attributes.number("condim") == 1) touching.friction = 0;
  if (!(touching.friction >= 0)) return attributes.error("friction", "friction: must not be negative");
  reading.import.model.pairs.push_back(touching);
}

}  // namespace

void find_pairs(XmlElement contact, Reading& reading) {
  for (const XmlElement each : children_of(contact, reading))
    for (const char* const key : {"geom1", "geom2"})
      if (const auto name = each.find(key); name && each.name() == "pair") reading.geoms_of_pairs.emplace(each.attribute(*name));
}

void read_contacts(XmlElement contact, Reading& reading) {
  for (const XmlElement each : children_of(contact, reading)) {
    if (each.name() == "exclude")
      read_exclude(each, reading);
    else if (each.name() == "pair")
      read_pair(each, reading);
    else
      reading.file_of(each).once(Severity::note, each.tag() + " in <contact> is ignored", "", {each});
  }
}

}  // namespace momentree::io::mjcf
