#include <momentree/results/columns/result_column.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/results/columns/energy_columns.hpp>
#include <momentree/results/columns/row_numbers.hpp>
#include <momentree/results/columns/spring_columns.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

constexpr std::array<std::string_view, 7> pose_names = {"x", "y", "z", "qw", "qx", "qy", "qz"};
constexpr std::string_view axis_names = "xyz";

// The place of "q0", "v12" among the numbers of its letter; −1 for another form.
int number_after_letter(std::string_view text) {
  if (text.size() < 2 || text.size() > 3) return -1;
  int number = 0;
  for (const char c : text.substr(1)) {
    if (c < '0' || c > '9') return -1;
    number = 10 * number + (c - '0');
  }
  return number;
}

std::string energy_unit(std::string_view name) {
  if (name.starts_with("linear.")) return "N s";
  return name.starts_with("angular.") ? "N m s" : "J";
}

std::string_view unit_of_dof(const KindInfo& kind, char group, std::size_t place) {
  const std::string_view letters = group == 'q' ? kind.q_units : kind.v_units;
  if (place >= letters.size() || letters[place] == 'n') return "";
  const bool turns = letters[place] == 'r';
  if (group == 'q') return turns ? "rad" : "m";
  if (group == 'v') return turns ? "rad/s" : "m/s";
  return turns ? "N m s" : "N s";
}

}  // namespace

std::optional<ResultColumn> ResultColumn::find(std::string_view name, const World& world, const std::vector<JointKinds>& joints,
                                               Diagnostic& problem) {
  ResultColumn column;
  column.name_ = name;
  if (name == "time") {
    column.unit_ = "s";
    return column;
  }
  const Model& model = world.model();
  const std::size_t dot = name.rfind('.');
  const std::string owner(name.substr(0, dot == std::string_view::npos ? 0 : dot));
  const std::string_view last = dot == std::string_view::npos ? name : name.substr(dot + 1);
  const auto joint = std::find_if(joints.begin(), joints.end(), [&](const JointKinds& each) { return each.name == owner; });
  const bool is_body = !owner.empty() && model.has_body(owner);
  if (is_body) {
    if (const auto found = std::find(pose_names.begin(), pose_names.end(), last); found != pose_names.end()) {
      column.of_ = Of::body;
      column.owner_ = owner;
      column.body_ = model.body(owner);
      column.place_ = static_cast<std::size_t>(found - pose_names.begin());
      column.unit_ = column.place_ < 3 ? "m" : "";
      return column;
    }
  }
  if (joint != joints.end() && !last.empty()) {
    column.of_ = Of::joint;
    column.owner_ = owner;
    column.group_ = last.front();
    if (last.size() == 2 && (last[0] == 'f' || last[0] == 'm') && axis_names.find(last[1]) != std::string_view::npos) {
      column.place_ = axis_names.find(last[1]);
      column.unit_ = last[0] == 'f' ? "N" : "N m";
      return column;
    }
    const int number = number_after_letter(last);
    const int count = last.front() == 'q' ? joint->nq : last.front() == 'v' || last.front() == 'p' ? joint->nv : 0;
    if (number >= 0 && number < count) {
      column.place_ = static_cast<std::size_t>(number);
      if (const int of_world = world.find_joint(owner); of_world >= 0)
        column.unit_ = unit_of_dof(info(world.joint(JointId{of_world}).kind), column.group_, column.place_);
      return column;
    }
  }
  const std::vector<std::string> energies = energy_column_names();
  if (const auto found = std::find(energies.begin(), energies.end(), name); found != energies.end()) {
    column.of_ = Of::energy;
    column.place_ = static_cast<std::size_t>(found - energies.begin());
    column.unit_ = energy_unit(name);
    return column;
  }
  const bool is_spring = model.has_spring(owner);
  if (const auto found = std::find(spring_column_names.begin(), spring_column_names.end(), last);
      is_spring && found != spring_column_names.end()) {
    column.of_ = Of::spring;
    column.owner_ = owner;
    column.place_ = static_cast<std::size_t>(found - spring_column_names.begin());
    column.unit_ = spring_column_units[column.place_];
    return column;
  }
  problem.what = "there is no column " + in_quotes(name);
  if (is_spring) {
    problem.hint = in_quotes(owner) + " has length rate tension";
    return std::nullopt;
  }
  if (is_body || joint != joints.end()) {
    problem.hint = is_body ? in_quotes(owner) + " has x y z qw qx qy qz" : in_quotes(owner) + " has";
    if (joint != joints.end()) {
      if (is_body) problem.hint += ", and its joint";
      for (const auto& [letter, count] : {std::pair{"q", joint->nq}, {"v", joint->nv}, {"p", joint->nv}})
        for (int k = 0; k < std::min(count, 8); ++k) problem.hint += std::string(" ") + letter + std::to_string(k);
      problem.hint += " fx fy fz mx my mz";
    }
    return std::nullopt;
  }
  std::vector<std::string> owners = energies;
  for (const BodySpec& body : model.bodies()) owners.push_back(body.name);
  for (const JointKinds& each : joints) owners.push_back(each.name);
  for (const Spring& each : model.springs()) owners.push_back(each.name);
  problem.hint = did_you_mean(owner.empty() ? std::string(name) : owner, owners);
  if (problem.hint.empty())
    problem.hint = "a column is named as in the tables of a run: \"tug/gripper.x\", \"arm/elbow.q0\", \"kinetic\"";
  return std::nullopt;
}

double ResultColumn::value(const Simulation& simulation) const {
  const World& world = simulation.world();
  switch (of_) {
    case Of::time: return world.time();
    case Of::energy: return energy_numbers(world, simulation.energy())[place_];
    case Of::body: {
      // Another world may have another model.
      const Model& model = world.model();
      BodyId body = body_;
      if (body.index >= model.size() || model[body].name != owner_) {
        if (!model.has_body(owner_)) return NAN;
        body = model.body(owner_);
      }
      const auto numbers = body_numbers(world, body);
      return place_ >= 3 && numbers[3] < 0 ? -numbers[place_] : numbers[place_];
    }
    case Of::spring: {
      const int spring = world.find_spring(owner_);
      return spring < 0 ? NAN : spring_numbers(world, spring)[place_];
    }
    case Of::joint: break;
  }
  const int number = world.find_joint(owner_);
  if (number < 0) return NAN;
  if (group_ == 'f' || group_ == 'm') return wrench_numbers(world.reaction(JointId{number}))[place_ + (group_ == 'f' ? 0 : 3)];
  const JointView joint = world.joint(JointId{number});
  const Numbers& numbers = group_ == 'q' ? joint.q : group_ == 'v' ? joint.v : joint.p;
  if (place_ >= numbers.size()) return NAN;
  if (!unit_.empty() && unit_of_dof(info(joint.kind), group_, place_) != unit_) return NAN;  // it has become another kind
  const std::size_t at = std::string_view(info(joint.kind).q_units).find('n');
  const bool turned = group_ == 'q' && at != std::string_view::npos && place_ >= at && place_ < at + 4 && joint.q[at] < 0;
  return turned ? -numbers[place_] : numbers[place_];
}

bool ResultColumn::of_ledger() const {
  return of_ == Of::energy && (name_ == "dissipated" || name_ == "work" || name_ == "error");
}

}  // namespace momentree::io
