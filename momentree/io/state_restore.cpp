// Puts state documents into a simulation.
#include <algorithm>
#include <cmath>

#include <momentree/io/number_text.hpp>
#include <momentree/io/state_document.hpp>

namespace momentree::io {

namespace {

struct Entry {
  const JointStart* start = nullptr;
  const std::string* where = nullptr;
};

/// Momenta depend on the velocities of the whole mechanism: they are used where every joint of it has one.
void choose_momenta(const Model& model, const std::vector<Body>& broken, const std::vector<Entry>& entries,
                    std::vector<JointStart>& starts) {
  const std::size_t n = entries.size();
  std::vector<bool> is_root(n, false);
  for (const Body body : broken) is_root[static_cast<std::size_t>(body.index)] = true;
  std::vector<std::size_t> root(n);
  std::vector<bool> complete(n, true);
  for (std::size_t b = 0; b < n; ++b) {  // parents have smaller numbers
    const BodySpec& body = model.bodies()[b];
    const bool breaks = is_root[b];
    root[b] = breaks || body.parent == ground ? b : root[static_cast<std::size_t>(body.parent.index)];
    const int nv = info(breaks ? Kind::free : body.joint.kind).nv;
    if (nv > 0 && (entries[b].start == nullptr || entries[b].start->p.empty())) complete[root[b]] = false;
  }
  for (JointStart& start : starts) {
    const auto b = static_cast<std::size_t>(start.child.index);
    if (start.p.empty() || complete[root[b]]) continue;
    if (start.v.empty())
      fail({"joint '" + model.bodies()[b].joint_name + "' has `p` and no `v`, but other joints of its mechanism have no `p`",
            *entries[b].where, "give `v`, or `p` of every joint of the mechanism"});
    start.p = {};
  }
}

double fastest_body(const World& world) {
  double speed = 0;
  for (const BodyMotion& motion : world.motions()) speed = std::max({speed, norm(motion.linear), norm(motion.angular)});
  return speed;
}

}  // namespace

void restore(Simulation& simulation, const std::vector<RestoredState>& documents) {
  const Model& model = simulation.world().model();
  std::vector<Entry> entries(model.bodies().size());
  std::vector<Body> broken;
  double time = simulation.time();
  for (const RestoredState& document : documents) {
    for (std::size_t i = 0; i < document.joints.size(); ++i)
      entries[static_cast<std::size_t>(document.joints[i].child.index)] = {&document.joints[i], &document.where[i]};
    broken.insert(broken.end(), document.broken.begin(), document.broken.end());
    time = document.time.value_or(time);
  }
  std::vector<JointStart> starts;
  for (const Entry& entry : entries)
    if (entry.start != nullptr) starts.push_back(*entry.start);
  choose_momenta(model, broken, entries, starts);
  simulation.restore(time, broken, starts);

  const World& world = simulation.world();
  const double tolerance = 1e-6 * fastest_body(world);
  for (const JointStart& start : starts) {
    if (start.p.empty() || start.v.empty()) continue;
    const JointView joint = world.joint(start.child);
    for (int i = 0; i < start.v.size(); ++i) {
      const double v = joint.v[static_cast<std::size_t>(i)];
      if (!(std::fabs(v - start.v[i]) <= tolerance))
        fail({"`v` of joint '" + std::string(joint.name) + "' does not fit its `p`: number " + std::to_string(i + 1) +
                  " should be " + number_text(v) + ", not " + number_text(start.v[i]),
              *entries[static_cast<std::size_t>(start.child.index)].where, "leave out one of the two"});
    }
  }
}

}  // namespace momentree::io
