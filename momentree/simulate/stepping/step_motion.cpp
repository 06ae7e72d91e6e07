#include <momentree/simulate/stepping/step_motion.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

double StepMotion::energy() const {
  const Totals now = world_->world().totals();
  return now.kinetic + now.potential;
}

void StepMotion::apply(StepImpulses& impulses, State& state, EnergyLedger& ledger, double h) {
  const Tree& tree = world_->tree();
  contact::ManyPoints& many = impulses.many;
  free_q_.assign(state.q().begin(), state.q().end()), free_u_.assign(state.u().begin(), state.u().end());
  const bool driven = !tree.joints_with().motions.empty() || (!impulses.near.empty() && impulses.rows.has_belts());
  const double before = energy(), kinetic = driven ? world_->world().totals().kinetic : 0.0;
  {
    const State::Edit edit = state.edit();
    impulses.parts.add_to(tree, many, many.change(), edit.u.data());
  }
  double by_drives = 0;
  if (driven) {
    // Prescribed motions and belts take up impulses without moving differently: what the other bodies gain is their work.
    by_drives = world_->world().totals().kinetic - kinetic;
    for (std::size_t row = 0; row < many.r.size(); ++row) by_drives -= 0.5 * many.r[row] * (many.b[row] + impulses.after[row]);
  }
  contact::LinksMotion& moved = many.displacement(impulses.reached);
  displace(impulses, state, moved);
  const double struck = energy();
  ledger.work += by_drives, ledger.impacts += before + by_drives - struck;
  double size = 1;
  for (std::size_t i = 0; i < impulses.near.size(); ++i) size = std::max(size, norm(impulses.rows.touches[i].point));
  const double deepest = deepest_after(impulses, state, moved);
  if (deepest > policy::least_depth * size) {
    contact::LinksMotion& apart = many.separate(gaps_, pushes_);
    // Where nothing gives way, such as below a body whose motion is prescribed, overlaps are left.
    for (std::size_t i = 0; deepest > left_by_steps && i < impulses.near.size(); ++i)
      if (const double depth = -gaps_[i] - many.along_normal(i, apart); depth > left_by_steps)
        overlapping_.emplace_back(impulses.near[i].pair, depth);
    displace(impulses, state, apart);
    ledger.projection += energy() - struck;
  }
  take_back_work(impulses, state.time(), ledger, h);
}

// Finds the gaps of all points after a motion; returns the depth of the deepest overlap (m).
double StepMotion::deepest_after(StepImpulses& impulses, const State& state, contact::LinksMotion& moved) {
  const Tree& tree = world_->tree();
  gaps_.clear();
  for (std::size_t i = 0; i < impulses.near.size(); ++i)
    gaps_.push_back(impulses.rows.touches[i].gap + impulses.many.along_normal(i, moved));
  for (const StepImpulses::NearStop& near : impulses.stops) {
    const double q = state.q()[static_cast<std::size_t>(tree.first_q(near.stop.body) + near.stop.dof)];
    gaps_.push_back(near.stop.sign * (near.stop.limit - q));
  }
  gaps_.resize(impulses.many.points.size(), HUGE_VAL);  // moments have none
  double deepest = 0;
  for (const double gap : gaps_) deepest = std::max(deepest, -gap);
  return deepest;
}

// Bodies that lie on something fall with it in each step, and are moved back: dampers and efforts do nothing in that, as a whole.
// The velocity of such a body grows from zero in the step. The work of efforts is then half of the power at the end times h, and
// what dampers take, which grows with its square, a third. Bodies that bounce do not rest. What prescribed motions do is in
// apply().
void StepMotion::take_back_work(StepImpulses& impulses, double t, EnergyLedger& ledger, double h) {
  const Tree& tree = world_->tree();
  if ((free_power_.dissipated == 0 && free_power_.work == 0) || !tree.joints_with().motions.empty() || tree.loops().motions > 0)
    return;
  impulses.forget_bounces();
  packed_.assign(static_cast<std::size_t>(tree.nv()), 0.0);
  impulses.parts.add_to(tree, impulses.many, impulses.many.displacement(impulses.reached), packed_.data());
  for (std::size_t i = 0; i < packed_.size(); ++i) packed_[i] = free_u_[i] + 2 / h * packed_[i];
  world_->evaluator()(t, free_q_.data(), packed_.data());
  const Power& there = world_->workspace().power;
  const double work = h / 2 * (there.work - free_power_.work), dissipated = h / 3 * (there.dissipated - free_power_.dissipated);
  ledger.work += work, ledger.dissipated += dissipated, ledger.impacts += work - dissipated;
}

void StepMotion::displace(StepImpulses& impulses, State& state, contact::LinksMotion& by) {
  const Tree& tree = world_->tree();
  packed_.assign(static_cast<std::size_t>(tree.nv()), 0.0);
  impulses.parts.add_to(tree, impulses.many, by, packed_.data());
  const double t = state.time();
  const State::Edit edit = state.edit();
  displacement_.apply(tree, t, packed_.data(), edit.q.data(), edit.u.data(), world_->workspace());
  double ignored = 0;
  if (tree.has_loops()) static_cast<void>(world_->evaluator().close(t, edit.q.data(), edit.u.data(), ignored));
}

}  // namespace momentree
