#pragma once
// What bodies and topologies consist of, for archives.
#include <algorithm>

#include <momentree/contact/primitive.hpp>
#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/scenario/events/joint_fields.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

template <class Archive>
void fields(Archive& archive, Part<Archive, BodyId>& body) {
  archive(body.index);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, BodySpec>& b) {
  archive(b.name, b.mass, b.com, b.inertia, b.parent, b.at, b.joint, b.q, b.v, b.child_at, b.joint_name);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, contact::Solid::Edge>& e) {
  archive(e.ends[0], e.ends[1], e.faces[0], e.faces[1]);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, contact::Solid::Face>& f) {
  archive(f.normal, f.offset, f.corners, f.plane);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, contact::Solid>& s) {
  archive(s.vertices, s.edges, s.faces, s.along, s.radius, s.centre, s.reach, s.thickness, s.rim, s.ends, s.axes, s.surface,
          s.belt);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, contact::HeightField>& f) {
  archive(f.at, f.x, f.y, f.columns, f.rows, f.heights, f.lowest, f.highest, f.convex);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Collider>& c) {
  archive(c.body, c.solid, c.plane, c.point, c.normal, c.field);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, ContactLaw>& l) {
  archive(l.friction, l.static_friction, l.torsional, l.rolling, l.restitution, l.off);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, ContactRule>& r) {
  archive(r.name, r.one, r.other, r.law, r.one_name, r.other_name);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, Topology::Place>& p) {
  archive(p.parent, p.joint, p.reversed);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Topology::Changed>& c) {
  archive(c.joint, c.as);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Topology::Own>& o) {
  archive(o.joint, o.parameters);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Topology::SpringChange>& s) {
  archive(s.spring, s.broken, s.law);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Loop>& l) {
  archive(l.number, l.body, l.to, l.joint, l.parameters, l.held);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, contact::Features>& f) {
  unsigned pair = static_cast<unsigned>(f.pair) | f.surface_a * 0x100u | f.surface_b * 0x10000u;
  archive(pair, f.point_a, f.line_a, f.point_b, f.line_b, f.radius_a, f.radius_b, f.side, f.rim, f.length);
  for (std::size_t k = 0; k < 3; ++k) archive(f.axes_a[k], f.axes_b[k]);
  if constexpr (!Archive::writes) {
    archive.require((pair & 0xffu) <= static_cast<unsigned>(contact::FeaturePair::ellipsoids) && pair < 0x1000000u);
    f.pair = static_cast<contact::FeaturePair>(pair & 0xffu);
    f.surface_a = static_cast<unsigned char>(pair >> 8), f.surface_b = static_cast<unsigned char>(pair >> 16);
    archive.require(std::max(f.surface_a, f.surface_b) <= std::variant_size_v<contact::Primitive>);
  }
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Contact>& c) {
  auto mode = static_cast<unsigned>(c.mode);
  archive(c.features, c.a, c.b, c.belt_a, c.belt_b, mode, c.friction, c.direction, c.keeps_direction, c.pair, c.id, c.settles,
          c.cable, c.pending);
  if constexpr (!Archive::writes) {
    archive.require(mode <= static_cast<unsigned>(Contact::Mode::slip));
    c.mode = static_cast<Contact::Mode>(mode);
  }
}
/// Without functions. Masses of added bodies are those of WorldSnapshot::added.
template <class Archive>
void fields(Archive& archive, Part<Archive, Topology>& t) {
  archive(t.places, t.changed, t.own, t.springs, t.loops, t.ended_couplings, t.contacts, t.model);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Turns>& t) {
  archive(t.first, t.second);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Snapshot>& s) {
  bool velocities = s.variables == Variables::velocities;
  archive(s.topology, s.time, s.q, s.y, s.turns, velocities);
  if constexpr (!Archive::writes) s.variables = velocities ? Variables::velocities : Variables::momenta;
}
template <class Archive>
void fields(Archive& archive, Part<Archive, ActiveLimit>& l) {
  archive(l.joint, l.dof, l.sign);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, WorldSnapshot>& w) {
  archive(w.engine, w.joint_names, w.mechanism_names, w.active_limits, w.added, w.added_colliders, w.former_contacts,
          w.overlapping, w.gravity);
  if constexpr (!Archive::writes)
    for (const BodySpec& body : w.added) w.engine.topology.added.push_back({body.mass, body.com, body.inertia});
}

}  // namespace momentree::io
