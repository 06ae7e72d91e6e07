#pragma once
// What the state of a run consists of, for archives.
#include <momentree/results/checkpoint/model_fields.hpp>
#include <momentree/simulate/run_state.hpp>

namespace momentree::io {

template <class Archive>
void fields(Archive& archive, Part<Archive, EventStatus>& s) {
  archive(s.time, s.fired, s.done, s.since, s.resting, s.excess, s.excess_before, s.looked, s.looked_before);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Approach>& a) {
  archive(a.excess, a.time, a.held);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, QueueState::Entry>& e) {
  fields(archive, static_cast<Part<Archive, EventStatus>&>(e));
  archive(e.nearest);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Strength>& s) {
  archive(s.joint, s.torque, s.most, s.spring);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, QueueState::Borne>& b) {
  archive(b.strength, b.event, b.joint, b.entry);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, DeeperStop>& s) {
  archive(s.joint, s.dof, s.sign, s.edge);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, QueueState>& q) {
  archive(q.entries, q.strengths, q.strengths_known, q.deeper_stops, q.next);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, EnergyBalance>& e) {
  archive(e.initial, e.final, e.dissipated, e.work, e.lost_in_impacts, e.released, e.error, e.projection, e.largest_kinetic);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, RunStatistics>& s) {
  for (const int after : {0, 1}) archive(s.evaluation_seconds[after], s.total_seconds[after], s.evaluations[after]);
  archive(s.topology_seconds, s.steps, s.changes, s.worst_step_seconds, s.contact_residual, s.contact_residual_at);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, ProgressMonitor::Mark>& m) {
  archive(m.steps, m.time, m.events);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, Totals>& t) {
  archive(t.kinetic, t.potential, t.linear, t.angular, t.loops.rows, t.loops.rank, t.loops.residual);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, ActionRecord>& a) {
  archive(a.kind, a.target, a.joint, a.body, a.to, a.skipped, a.spring);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, JointRecord>& j) {
  archive(j.name);
  kind(archive, j.kind);
  archive(j.parent, j.child, j.at, j.child_at, j.axis, j.axis2, j.pitch, j.locked, j.loop);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, TopologyRecord::Moved>& m) {
  archive(m.mechanism, m.bodies);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, TopologyRecord>& t) {
  archive(t.gone, t.joints, t.moved, t.broken_springs, t.ended_couplings);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Event::OfCoupling>& c) {
  archive(c.joint, c.follows, c.on_joint, c.on_follows);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Event::Contact>& c) {
  archive(c.one, c.other, c.point, c.normal, c.impulse, c.scaled, c.in_turn, c.cable);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, MechanismNames>& names) {
  MechanismNames::Shared all = names.shared();
  archive(all);
  if constexpr (!Archive::writes) {
    archive.require(all != nullptr);
    names = MechanismNames(std::move(all));
  }
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Event>& e) {
  archive(e.time, e.name, e.actions, e.topology, e.mechanisms_before, e.mechanisms_after, e.before, e.after, e.released, e.lost,
          e.work, e.impulse, e.ground_impulse, e.coupling_impulse, e.contact, e.hardest_joint, e.hardest_linear,
          e.hardest_angular, e.duration_ns, e.reason, e.stepped);
}

template <class Archive>
void fields(Archive& archive, Part<Archive, SteppedContact>& c) {
  archive(c.pair, c.id, c.a, c.b, c.point, c.normal, c.force, c.slip, c.cable, c.joint, c.side, c.rests, c.moment);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Overlap>& o) {
  archive(o.one, o.other, o.depth, o.cable, o.a, o.b);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, KeptOverlap>& o) {
  archive(o.deepest, o.since);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, SteppingState>& s) {
  describe_in_documents(archive, s);
  archive(s.points, s.placed, s.overlaps);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, RunState>& r) {
  archive(r.world, r.queue, r.balance, r.dissipated, r.work, r.proposal, r.impacts, r.stepping, r.evaluated, r.evaluations,
          r.evaluation_seconds, r.statistics, r.progress, r.within_run, r.keeps_closed, r.observed, r.observed_at,
          r.next_observation, r.events);
}

}  // namespace momentree::io
