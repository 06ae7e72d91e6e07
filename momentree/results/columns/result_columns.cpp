#include <momentree/results/columns/result_columns.hpp>

#include <algorithm>
#include <map>
#include <string_view>

#include <momentree/results/columns/row_numbers.hpp>
#include <momentree/simulate/events/instant.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

Quat ContinuousQuaternions::next(std::size_t index, const Quat& q) {
  Quat& last = last_[index];
  const double along = last.w * q.w + last.x * q.x + last.y * q.y + last.z * q.z;
  const bool turn = along != 0 ? along < 0 : q.w < 0;
  return last = turn ? Quat{-q.w, -q.x, -q.y, -q.z} : q;
}

namespace {

void append_cell(std::string& text, double value) {
  text += ',';
  append_number(text, value);
}

// A name with a comma or a quote is quoted as in RFC 4180.
void append_column(std::string& text, const std::string& name, const std::string& suffix) {
  text += ',';
  if (name.find_first_of(",\"\r\n") == std::string::npos) {
    text += name + suffix;
    return;
  }
  text += '"';
  for (const char c : name) text.append(c == '"' ? 2 : 1, c);
  text += suffix + '"';
}

}  // namespace

BodyColumns::BodyColumns(const World& world) : quaternions_(static_cast<std::size_t>(world.model().size())) {
  for (int b = 0; b < world.model().size(); ++b)
    if (world.alive({b})) bodies_.push_back(b);
}

void BodyColumns::header(std::string& text, const Model& model) const {
  text += "time";
  for (const int b : bodies_)
    for (const char* suffix : {".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"}) append_column(text, model[BodyId{b}].name, suffix);
  text += '\n';
}

void BodyColumns::row(std::string& text, const World& world) {
  append_number(text, world.time());
  const std::vector<BodyMotion>& motions = world.motions();
  for (const int b : bodies_) {
    const auto i = static_cast<std::size_t>(b);
    if (!world.alive({b})) {
      text.append(7, ',');
      continue;
    }
    const Vec3& r = motions[i].pose.position;
    const Quat q = quaternions_.next(i, motions[i].pose.rotation);
    for (const double x : {r.x, r.y, r.z, q.w, q.x, q.y, q.z}) append_cell(text, x);
  }
  text += '\n';
}

std::vector<JointKinds> joints_of(const Simulation& simulation, const DryRun& dry_run, const Scenario& scenario) {
  const World& world = simulation.world();
  const Model& model = world.model();
  std::map<std::string, JointKinds> all;
  const auto widen = [&all](const std::string& name, Kind kind) {
    JointKinds& joint = all[name];
    joint.name = name;
    joint.nq = std::max(joint.nq, info(kind).nq);
    joint.nv = std::max(joint.nv, info(kind).nv);
  };
  for (const auto& [name, kind] : dry_run.joints) widen(name, kind);
  if (!dry_run.complete) {
    for (const ScenarioEvent& event : scenario.events)
      for (std::size_t a = 0; a < event.actions.size(); ++a) {
        const ActionBase& action = *event.actions[a];
        if (const std::string made = made_joint_name({event.name, event.named, event.actions}, a); !made.empty())
          widen(made, action.resulting_kind().value_or(Kind::free));
        if (action.effect() != JointEffect::removed) continue;
        for (const std::string& joint : action.joints()) {
          if (!model.has_joint(joint) || is_loop(model.joint(joint))) continue;
          const std::string& body = model[model.joint(joint)].name;
          widen(body == joint || !model.has_joint(body) ? body : body + "~free", Kind::free);
        }
      }
  }
  std::vector<JointKinds> joints;
  for (int j = 0; j < model.size(); ++j) {
    if (world.tree().carrier(j) < 0) continue;  // the joint was removed together with its body
    const std::string name(world.joint_name({j}));
    widen(name, world.tree().joint(world.tree().carrier(j)).kind);
    joints.push_back(std::move(all[name]));
    all.erase(name);
  }
  for (const JointId loop : world.loops()) {
    const std::string name(world.joint_name(loop));
    widen(name, world.joint(loop).kind);
    joints.push_back(std::move(all[name]));
    all.erase(name);
  }
  for (auto& [name, joint] : all) joints.push_back(std::move(joint));
  return joints;
}

JointColumns::JointColumns(std::vector<JointKinds> joints, bool reactions)
    : reactions_(reactions), groups_(std::move(joints)), quaternions_(groups_.size() + 1) {
  for (std::size_t g = 0; g < groups_.size(); ++g) by_name_.emplace(groups_[g].name, g);
  joint_of_group_.resize(groups_.size() + 1);
}

void JointColumns::header(std::string& text) const {
  text += "time";
  for (const JointKinds& group : groups_) {
    for (int k = 0; k < group.nq; ++k) append_column(text, group.name, ".q" + std::to_string(k));
    for (int k = 0; k < group.nv; ++k) append_column(text, group.name, ".v" + std::to_string(k));
    for (int k = 0; k < group.nv; ++k) append_column(text, group.name, ".p" + std::to_string(k));
    if (reactions_)
      for (const char* suffix : {".fx", ".fy", ".fz", ".mx", ".my", ".mz"}) append_column(text, group.name, suffix);
  }
  text += '\n';
}

std::size_t JointColumns::group_of(std::size_t joint, std::string_view name) {
  std::size_t& group = group_of_joint_[joint];
  if (group == groups_.size() || groups_[group].name != name) {
    const auto found = by_name_.find(std::string(name));
    group = found == by_name_.end() ? groups_.size() : found->second;
  }
  return group;
}

namespace {
void append_cells(std::string& text, std::span<const double> values, int width) {
  for (const double x : values) append_cell(text, x);
  text.append(static_cast<std::size_t>(width) - values.size(), ',');
}
}  // namespace

void JointColumns::row(std::string& text, const World& world) {
  const auto joints = static_cast<std::size_t>(world.tree().bodies());
  const std::span<const Loop> loops = world.tree().loops();
  group_of_joint_.resize(joints + loops.size(), groups_.size());
  std::fill(joint_of_group_.begin(), joint_of_group_.end(), -1);
  for (std::size_t j = 0; j < joints; ++j)
    joint_of_group_[group_of(j, world.joint_name({static_cast<int>(j)}))] = static_cast<int>(j);
  for (std::size_t j = 0; j < loops.size(); ++j)
    joint_of_group_[group_of(joints + j, world.joint_name(loops[j].id()))] = loops[j].id().index;
  append_number(text, world.time());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const JointKinds& group = groups_[g];
    const int number = joint_of_group_[g];
    const auto width = static_cast<std::size_t>(group.nq + 2 * group.nv + (reactions_ ? 6 : 0));
    if (number < 0) {
      text.append(width, ',');
      continue;
    }
    const JointView joint = world.joint(JointId{number});
    const KindInfo& kind = info(joint.kind);
    if (kind.nq > group.nq || kind.nv > group.nv) {  // of a kind that no event was expected to give it
      text.append(width, ',');
      continue;
    }
    double q[Values::capacity];
    std::copy(joint.q.begin(), joint.q.end(), q);
    const std::size_t at = std::string_view(kind.q_units).find('n');
    if (at != std::string_view::npos) {
      const Quat turned = quaternions_.next(g, {q[at], q[at + 1], q[at + 2], q[at + 3]});
      q[at] = turned.w, q[at + 1] = turned.x, q[at + 2] = turned.y, q[at + 3] = turned.z;
    }
    append_cells(text, {q, joint.q.size()}, group.nq);
    append_cells(text, joint.v, group.nv);
    append_cells(text, joint.p, group.nv);
    if (!reactions_) continue;
    for (const double x : wrench_numbers(world.reaction(JointId{number}))) append_cell(text, x);
  }
  text += '\n';
}

}  // namespace momentree::io
