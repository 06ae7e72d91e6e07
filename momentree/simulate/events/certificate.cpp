// Impulses that the joints transmitted at an instantaneous change: the impulse through a joint is the change of its articulated
// momentum, S = Pb⁺ − Pb⁻.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree {

namespace {

// Transforms a wrench from the frame at `pose` to the surrounding frame.
Force<double> outward(const Pose& pose, const Force<double>& W) {
  const Mat3 R = rotation_matrix(pose.rotation);
  const Vec3 l = R * W.l;
  return {l, R * W.h + cross(pose.position, l)};
}

double size(const Force<double>& W) { return std::max(norm(W.l), norm(W.h)); }

// Impulses smaller than this fraction of the largest one are rounding errors.
constexpr double noise = 1e-13;

}  // namespace

Force<double> TopologyEditor::impulse_about(int b, const LoopImpulse& given) const {
  const Pose pose = user_pose(tree(), edit_.workspace().bodies[static_cast<std::size_t>(b)], b);
  const Mat3 R = rotation_matrix(pose.rotation);
  return {transpose_times(R, given.force), transpose_times(R, given.torque + cross(given.at - pose.position, given.force))};
}

void TopologyEditor::remember_momenta() {
  before_.resize(static_cast<std::size_t>(tree().bodies()));
  for (const int b : tree().order())
    before_[static_cast<std::size_t>(b)] =
        to_user_frame(tree().frame(b), articulated_momentum(tree(), edit_.state(), edit_.workspace(), b));
}

void TopologyEditor::book_impulses(std::span<const AppliedImpulse> applied) {
  std::vector<Force<double>>& sums = impulses_[event_];
  sums.resize(static_cast<std::size_t>(tree().bodies()));
  double largest = 0;
  for (const int b : tree().order()) {
    Force<double>& S = before_[static_cast<std::size_t>(b)];
    const Force<double> after = to_user_frame(tree().frame(b), articulated_momentum(tree(), edit_.state(), edit_.workspace(), b));
    S = {after.l - S.l, after.h - S.h};
  }
  locate_bodies(tree(), edit_.state(), edit_.workspace());
  const auto pose_of = [&](int b) { return user_pose(tree(), edit_.workspace().bodies[static_cast<std::size_t>(b)], b); };
  // An external impulse is contained in Pb of its body and of all inboard bodies, but no joint transmitted it.
  for (const AppliedImpulse& one : applied)
    for (int a = one.body; a >= 0; a = tree().parent(a)) {
      const Pose pose = pose_of(a);
      const Mat3 R = rotation_matrix(pose.rotation);
      Force<double>& S = before_[static_cast<std::size_t>(a)];
      S.l -= transpose_times(R, one.force);
      S.h -= transpose_times(R, one.torque + cross(one.point - pose.position, one.force));
    }
  // So are the impulses of loops, which are booked as those of their joints.
  for (std::size_t i = 0; i < loop_impulses_now_.size(); ++i) {
    const Loop& loop = tree().loops()[i];
    const LoopImpulse& given = loop_impulses_now_[i];
    const auto in_frame = [&](int b) { return impulse_about(b, given); };
    for (int a = loop.body; a >= 0; a = tree().parent(a)) {
      const Force<double> W = in_frame(a);
      Force<double>& S = before_[static_cast<std::size_t>(a)];
      S.l -= W.l, S.h -= W.h;
    }
    for (int a = loop.to; a >= 0; a = tree().parent(a)) before_[static_cast<std::size_t>(a)] += in_frame(a);
    const Force<double> on_child = in_frame(loop.body);
    if (size(on_child) == 0) continue;
    loop_impulses_[event_][joint_name(loop.id().index)] += on_child;
    if (loop.to >= 0) continue;
    const Force<double> W = outward(pose_of(loop.body), on_child);
    const double w[6] = {W.l.x, W.l.y, W.l.z, W.h.x, W.h.y, W.h.z};
    for (std::size_t k = 0; k < 6; ++k) event_->ground_impulse[k] += w[k];
  }
  book_coupling_impulses();
  for (const int b : tree().order()) largest = std::max(largest, size(before_[static_cast<std::size_t>(b)]));
  for (const int b : tree().order()) {
    const Force<double>& S = before_[static_cast<std::size_t>(b)];
    if (size(S) <= noise * largest) continue;
    const Pose pose = pose_of(b);
    const int outer = tree().parent(b);
    if (outer < 0) {
      const Force<double> W = outward(pose, S);
      const double w[6] = {W.l.x, W.l.y, W.l.z, W.h.x, W.h.y, W.h.z};
      for (std::size_t i = 0; i < 6; ++i) event_->ground_impulse[i] += w[i];
    }
    Force<double>& sum = sums[static_cast<std::size_t>(tree().joint_of(b))];
    if (tree().reversed(b)) {  // the declared child gets the opposite impulse, in its own frame
      const Force<double> W = outward(inverse(outer < 0 ? Pose{} : pose_of(outer)) * pose, S);
      sum.l -= W.l, sum.h -= W.h;
    } else {
      sum.l += S.l, sum.h += S.h;
    }
  }
}

void TopologyEditor::certify(Event& event) {
  for (const int joint : touched_[&event]) {
    std::string& name = names_at_start_[joint];  // empty: another event at this instant has reported it
    if (!name.empty() && world_.find_joint(name) < 0) event.topology.gone.push_back(std::exchange(name, {}));
    const bool exists = is_loop({joint}) ? tree().loops().find({joint}) != nullptr : tree().carrier(joint) >= 0;
    if (exists) event.topology.joints.push_back(joint_record(world_, {joint}));
  }
  add_impulses(event, event);
}

void TopologyEditor::certify_part(const Event& part, Event& event) {
  event.lost += part.lost, event.work += part.work, event.duration_ns += part.duration_ns;
  for (std::size_t k = 0; k < 6; ++k) event.ground_impulse[k] += part.ground_impulse[k];
  event.coupling_impulse.insert(event.coupling_impulse.end(), part.coupling_impulse.begin(), part.coupling_impulse.end());
  add_impulses(part, event);
}

// Adds the impulses of the joints at a part of an event, and finds the hardest one.
void TopologyEditor::add_impulses(const Event& part, Event& event) {
  const auto known = event.impulse.size();
  const auto add = [&](const std::string& name, const Force<double>& S) {
    if (norm(S.l) == 0 && norm(S.h) == 0) return;
    const std::array<double, 6> more{S.l.x, S.l.y, S.l.z, S.h.x, S.h.y, S.h.z};
    for (std::size_t i = 0; i < known; ++i)
      if (event.impulse[i].first == name) {
        for (std::size_t k = 0; k < 6; ++k) event.impulse[i].second[k] += more[k];
        return;
      }
    event.impulse.push_back({name, more});
  };
  if (const auto found = impulses_.find(&part); found != impulses_.end())
    for (std::size_t j = 0; j < found->second.size(); ++j) add(joint_name(static_cast<int>(j)), found->second[j]);
  if (const auto found = loop_impulses_.find(&part); found != loop_impulses_.end())
    for (const auto& [name, S] : found->second) add(name, S);
  event.hardest_joint.clear(), event.hardest_linear = event.hardest_angular = 0;
  for (const auto& [name, S] : event.impulse) {
    const double linear = norm(Vec3{S[0], S[1], S[2]}), angular = norm(Vec3{S[3], S[4], S[5]});
    if (event.hardest_joint.empty() || linear > event.hardest_linear ||
        (linear == event.hardest_linear && angular > event.hardest_angular))
      event.hardest_joint = name, event.hardest_linear = linear, event.hardest_angular = angular;
  }
  // An event that loses nothing shows no loss of the size of rounding errors.
  double energies = 0;
  for (const Totals* totals : {&event.before, &event.after})
    energies += std::fabs(totals->kinetic) + std::fabs(totals->potential);
  if (event.lost < 0 && event.lost >= -noise * energies) event.lost = 0;
}

}  // namespace momentree
