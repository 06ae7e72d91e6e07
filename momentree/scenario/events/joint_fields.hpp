#pragma once
// What joints consist of, for archives.
#include <cmath>

#include <momentree/simulate/events/argument.hpp>
#include <momentree/text/archive.hpp>

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
template <class Archive>
void fields(Archive& archive, Part<Archive, Sym3>& m) {
  archive(m.xx, m.yy, m.zz, m.xy, m.xz, m.yz);
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
void fields(Archive& archive, Part<Archive, JointSpec>& j) {
  kind(archive, j.kind);
  archive(j.axis, j.axis2, j.pitch, j.parameters);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointDescription>& j) {
  archive(j.spec, j.axis_given, j.axis2_given);
}

}  // namespace momentree::io
