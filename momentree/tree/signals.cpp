// Functions of time among the drives and forces of a tree.
#include <algorithm>
#include <cmath>

#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

template <class Look>
void for_signals(const Tree& tree, Look look) {
  const auto look_at = [&](const JointDrive* drive) {
    if (drive == nullptr) return;
    for (const auto* signals : {&drive->effort, &drive->pd.target, &drive->pd.target_speed})
      for (const Signal& s : *signals) look(s);
    for (const Curve& c : drive->motion) look(c.signal());
  };
  for (const auto* joints : {&tree.joints_with().forces, &tree.joints_with().motions})
    for (const int b : *joints)
      if (const JointParameters* p = tree.parameters(b)) look_at(p->drive.get());
  for (const Loop& loop : tree.loops()) look_at(loop.parameters.drive.get());
  for (const BodyForce& force : tree.loads().forces)
    if (tree.alive(force.body.index))
      for (const auto* signals : {&force.force, &force.torque})
        for (const Signal& s : *signals) look(s);
}

}  // namespace

double next_bend(const Tree& tree, double t) {
  double next = HUGE_VAL;
  for_signals(tree, [&](const Signal& s) { next = std::min(next, s.next_bend(t)); });
  return next;
}

double shortest_period(const Tree& tree) {
  double shortest = HUGE_VAL;
  for_signals(tree, [&](const Signal& s) {
    if (s.amplitude() != 0 && s.frequency() != 0) shortest = std::min(shortest, 1 / std::fabs(s.frequency()));
  });
  return shortest;
}

}  // namespace momentree
