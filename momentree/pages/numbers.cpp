// Numerical data of a world, in the arrays that wasm/engine.h documents.
#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/pages/page_world.hpp>
#include <momentree/results/columns/row_numbers.hpp>
#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::io {

namespace {
constexpr double none = std::numeric_limits<double>::quiet_NaN();

double load_of(double force, double torque, const JointParameters* parameters) {
  if (parameters == nullptr || !parameters->strength.any()) return none;
  return std::max(force / parameters->strength.force, torque / parameters->strength.torque);
}
}  // namespace

void fill_motions(const World& world, std::vector<double>& all) {
  all.clear();
  for (std::size_t b = 0; b < world.motions().size(); ++b) {
    const std::array<double, motion_size> numbers = body_numbers(world, {static_cast<int>(b)});
    all.insert(all.end(), numbers.begin(), numbers.end());
  }
}

std::vector<Threshold> thresholds_of(const Scenario& scenario, const World& world) {
  std::vector<Threshold> all;
  for (const ScenarioEvent& event : scenario.events) {
    if (!event.condition || !event.condition->what->is_load() || event.condition->threshold == 0) continue;
    for (const std::string& joint : event.condition->what->joints())
      if (const int number = world.find_joint(joint); number >= 0) all.push_back({number, *event.condition});
  }
  return all;
}

void fill_joints(const Simulation& simulation, const std::vector<Threshold>& thresholds, bool reactions,
                 std::vector<double>& all) {
  const World& world = simulation.world();
  const int rows = joint_row_count(world);
  all.assign(static_cast<std::size_t>(rows) * joint_size, 0);
  const auto row_at = [&all](int place) { return all.data() + static_cast<std::ptrdiff_t>(place) * joint_size; };
  for (int r = 0; r < rows; ++r) row_at(r)[0] = -1, row_at(r)[27] = none, row_at(r)[28] = 1;
  for (const JointId number : present_joints(world)) {
    double* const row = row_at(row_of(world, number));
    const JointView joint = world.joint(number);
    row[0] = static_cast<double>(joint.q.size()), row[1] = static_cast<double>(joint.v.size());
    std::copy(joint.q.begin(), joint.q.end(), row + 2);
    std::copy(joint.v.begin(), joint.v.end(), row + 9);
    std::copy(joint.p.begin(), joint.p.end(), row + 15);
    if (!reactions) continue;
    const JointForces forces = world.joint_forces(number);
    const Wrench& w = forces.reaction;
    std::ranges::copy(wrench_numbers(w), row + 21);
    row[28] = forces.determined ? 1 : 0;
    row[27] = load_of(norm(w.force), norm(w.torque), world.joint(number).parameters);
  }
  if (!reactions) return;
  for (const Threshold& each : thresholds) {
    const int place = row_of(world, {each.joint});
    if (place >= rows || row_at(place)[0] < 0) continue;
    double* const row = row_at(place);
    const std::optional<double> value = each.condition.what->value(world, {});
    if (!value) continue;
    row[27] = std::fmax(row[27], std::fabs(*value / each.condition.threshold));
  }
}

void fill_totals(const Simulation& simulation, double* all) {
  const Totals t = simulation.world().totals();
  const EnergyBalance e = simulation.energy();
  const double numbers[totals_size] = {simulation.time(), t.kinetic,    t.potential, t.linear.x,        t.linear.y,
                                       t.linear.z,        t.angular.x,  t.angular.y, t.angular.z,       e.initial,
                                       e.final,           e.dissipated, e.work,      e.lost_in_impacts, e.released,
                                       e.error,           e.projection};
  std::copy(std::begin(numbers), std::end(numbers), all);
}

}  // namespace momentree::io
