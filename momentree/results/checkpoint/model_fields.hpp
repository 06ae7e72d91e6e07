#pragma once
// What joints and topologies consist of, for archives.
#include <algorithm>
#include <cmath>

#include <momentree/contact/primitive.hpp>
#include <momentree/results/checkpoint/archive.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

template <class Archive>
void fields(Archive& archive, Part<Archive, Vec3>& v) {
  archive(v.x, v.y, v.z);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Quat>& q) {
  archive(q.w, q.x, q.y, q.z);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Pose>& pose) {
  archive(pose.position, pose.rotation);
}

inline void fields(ArchiveWriter& archive, const Values& values) {
  archive(values.size());
  for (const double x : values) archive(x);
}
inline void fields(ArchiveReader& archive, Values& values) {
  int size = 0;
  archive(size);
  archive.require(size >= 0 && size <= Values::capacity);
  values = {};
  for (double x = 0; size > 0; --size) {
    archive(x);
    values.push_back(x);
  }
}

template <class Archive>
void fields(Archive& archive, Part<Archive, Signal::Knot>& knot) {
  archive(knot.time, knot.value);
}

struct SavedSignal {
  double offset = 0, amplitude = 0, frequency = 0, phase = 0, ramp = 0;
  bool free_ends = false, from_here = false;
  std::vector<Signal::Knot> knots;
};
template <class Archive>
void fields(Archive& archive, Part<Archive, SavedSignal>& s) {
  archive(s.offset, s.amplitude, s.frequency, s.phase, s.ramp, s.free_ends, s.from_here, s.knots);
}
inline void fields(ArchiveWriter& archive, const Signal& s) {
  archive(SavedSignal{s.offset(),
                      s.amplitude(),
                      s.frequency(),
                      s.phase(),
                      s.ramp_rate(),
                      s.ends() == Signal::Ends::free,
                      s.from_here(),
                      {s.knots().begin(), s.knots().end()}});
}
inline void fields(ArchiveReader& archive, Signal& signal) {
  SavedSignal s;
  archive(s);
  if (!s.knots.empty())
    signal = Signal::table(std::move(s.knots), s.free_ends ? Signal::Ends::free : Signal::Ends::rest);
  else if (s.from_here)  // at the time ±0 whose product with the rate is +0: the offset is exact
    signal = Signal::ramp_from_here(s.ramp).begun_at(s.offset, std::copysign(0.0, s.ramp));
  else if (s.ramp != 0)
    signal = Signal::ramp(s.ramp, s.offset);
  else
    signal = Signal::sine(s.amplitude, s.frequency, s.phase, s.offset);
}
inline void fields(ArchiveWriter& archive, const Curve& curve) { archive(curve.signal()); }
inline void fields(ArchiveReader& archive, Curve& curve) {
  Signal signal;
  archive(signal);
  curve = Curve(signal);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, JointLimits>& l) {
  archive(l.lower, l.upper, l.restitution, l.rest_speed, l.stiffness, l.damping);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointFriction>& f) {
  archive(f.coulomb, f.speed);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointStrength>& s) {
  archive(s.force, s.torque);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointDrive>& d) {
  archive(d.effort, d.pd.kp, d.pd.kd, d.pd.target, d.pd.target_speed, d.pd.max_effort, d.motion);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointParameters>& p) {
  archive(p.damping, p.stiffness, p.rest, p.armature, p.effort, p.limits, p.friction, p.strength, p.drive);
}

template <class Archive>
void kind(Archive& archive, Part<Archive, Kind>& kind) {
  auto number = static_cast<unsigned>(kind);
  archive(number);
  if constexpr (!Archive::writes) {
    archive.require(number < all_kinds().size());
    kind = static_cast<Kind>(number);
  }
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Joint>& j) {
  kind(archive, j.kind);
  archive(j.parameters, j.at, j.child_at, j.axis, j.axis2, j.pitch, j.locked, j.created_by_event, j.function);
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
/// Without functions and added bodies.
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
  archive(w.engine, w.joint_names, w.mechanism_names, w.active_limits, w.former_contacts, w.overlapping, w.gravity);
}

}  // namespace momentree::io
