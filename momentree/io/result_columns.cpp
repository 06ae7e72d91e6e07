#include <momentree/io/result_columns.hpp>

#include <algorithm>
#include <string_view>

#include <momentree/io/number_text.hpp>

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

// A name with a comma or a quote in it is quoted as RFC 4180 says.
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

BodyColumns::BodyColumns(const Model& model) : quaternions_(model.bodies().size()) {}

void BodyColumns::header(std::string& text, const Model& model) {
  text += "time";
  for (const BodySpec& body : model.bodies())
    for (const char* suffix : {".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"}) append_column(text, body.name, suffix);
  text += '\n';
}

void BodyColumns::row(std::string& text, const World& world) {
  append_number(text, world.time());
  const std::vector<BodyMotion>& motions = world.motions();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Vec3& r = motions[i].pose.position;
    const Quat q = quaternions_.next(i, motions[i].pose.rotation);
    for (const double x : {r.x, r.y, r.z, q.w, q.x, q.y, q.z}) append_cell(text, x);
  }
  text += '\n';
}

JointColumns::JointColumns(const Model& model, const std::vector<Body>& breakable)
    : group_of_body_(model.bodies().size(), 0), quaternions_(model.bodies().size()) {
  std::vector<bool> breaks(model.bodies().size(), false);
  for (const Body body : breakable) breaks[static_cast<std::size_t>(body.index)] = true;
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    const BodySpec& body = model.bodies()[i];
    widen(body.joint_name, info(body.joint.kind));
    if (breaks[i]) widen(body.name, info(Kind::free));
  }
  body_of_group_.resize(groups_.size());
}

void JointColumns::widen(const std::string& name, const KindInfo& kind) {
  const auto [found, added] = by_name_.try_emplace(name, groups_.size());
  if (added) groups_.push_back({name});
  Group& group = groups_[found->second];
  group.nq = std::max(group.nq, kind.nq);
  group.nv = std::max(group.nv, kind.nv);
}

void JointColumns::header(std::string& text) const {
  text += "time";
  for (const Group& group : groups_) {
    for (int k = 0; k < group.nq; ++k) append_column(text, group.name, ".q" + std::to_string(k));
    for (int k = 0; k < group.nv; ++k) append_column(text, group.name, ".v" + std::to_string(k));
    for (int k = 0; k < group.nv; ++k) append_column(text, group.name, ".p" + std::to_string(k));
  }
  text += '\n';
}

std::size_t JointColumns::group_of(std::size_t body, std::string_view name) {
  std::size_t& group = group_of_body_[body];
  if (groups_[group].name != name) {
    const auto found = by_name_.find(std::string(name));
    MT_REQUIRE(found != by_name_.end(), "every joint that an event makes is known before the run");
    group = found->second;
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
  std::fill(body_of_group_.begin(), body_of_group_.end(), -1);
  for (std::size_t i = 0; i < group_of_body_.size(); ++i) {
    const Body body{static_cast<int>(i)};
    body_of_group_[group_of(i, world.joint(body).name)] = body.index;
  }
  append_number(text, world.time());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const int body = body_of_group_[g];
    if (body < 0) {
      text.append(static_cast<std::size_t>(group.nq + 2 * group.nv), ',');
      continue;
    }
    const JointView joint = world.joint(Body{body});
    double q[Values::capacity];
    std::copy(joint.q.begin(), joint.q.end(), q);
    const std::size_t at = std::string_view(info(joint.kind).q_units).find('n');
    if (at != std::string_view::npos) {
      const Quat turned = quaternions_.next(static_cast<std::size_t>(body), {q[at], q[at + 1], q[at + 2], q[at + 3]});
      q[at] = turned.w, q[at + 1] = turned.x, q[at + 2] = turned.y, q[at + 3] = turned.z;
    }
    append_cells(text, {q, joint.q.size()}, group.nq);
    append_cells(text, joint.v, group.nv);
    append_cells(text, joint.p, group.nv);
  }
  text += '\n';
}

}  // namespace momentree::io
