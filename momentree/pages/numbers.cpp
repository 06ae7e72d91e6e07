// Numerical data of a world.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <momentree/pages/page_world.hpp>
#include <momentree/results/columns/row_numbers.hpp>
#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/text/base64.hpp>
#include <momentree/text/json_writer.hpp>

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

void fill_contacts(const World& world, std::vector<double>& all) {
  all.clear();
  for (const ContactPoint& point : world.contacts()) {
    all.insert(all.end(), {double(point.one.index), double(point.other.index)});
    for (const Vec3* v : {&point.point, &point.normal, &point.force, &point.slip}) all.insert(all.end(), {v->x, v->y, v->z});
    all.push_back(point.slips ? 1 : 0);
  }
}

PageFrame frame_of(const Simulation& simulation, const std::vector<Threshold>& thresholds) {
  std::vector<float> floats;
  const auto add = [&floats](std::initializer_list<double> numbers) {
    for (const double each : numbers) floats.push_back(static_cast<float>(each));
  };
  PageFrame frame;
  std::vector<double> rows;
  fill_motions(simulation.world(), rows);
  for (std::size_t b = 0; b < rows.size(); b += motion_size)
    for (std::size_t i = b; i < b + 7; ++i) add({rows[i]});
  frame.poses = floats.size();
  fill_joints(simulation, thresholds, true, rows);
  for (std::size_t j = 0; j < rows.size(); j += joint_size) {
    const double* const row = rows.data() + j;
    if (row[0] < 0)
      add({none, none, 1, none, none, none});
    else
      add({row[27], std::hypot(row[21], row[22], row[23]), row[28], row[21], row[22], row[23]});
  }
  frame.loads = floats.size() - frame.poses;
  for (const ContactPoint& each : simulation.world().contacts())
    add({each.point.x, each.point.y, each.point.z, each.force.x, each.force.y, each.force.z});
  frame.contacts = floats.size() - frame.poses - frame.loads;
  double totals[totals_size];
  fill_totals(simulation, totals);
  frame.bytes.resize(sizeof totals + floats.size() * sizeof(float));
  std::memcpy(frame.bytes.data(), totals, sizeof totals);
  if (!floats.empty()) std::memcpy(frame.bytes.data() + sizeof totals, floats.data(), floats.size() * sizeof(float));
  return frame;
}

std::string frame_json(const PageFrame& frame, bool with_numbers) {
  std::string text, numbers;
  JsonWriter json(text);
  json.begin_object().member("poses", static_cast<long>(frame.poses)).member("loads", static_cast<long>(frame.loads));
  json.member("contacts", static_cast<long>(frame.contacts));
  if (with_numbers) append_base64(numbers, frame.bytes), json.member("numbers", numbers);
  json.end_object();
  return text;
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
