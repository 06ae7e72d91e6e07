// Elements between joints in a world: they act as functions of their joints, and end with them.
#include <momentree/simulate/world/world_elements.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <momentree/dynamics/forces/evaluation_context.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/lasting_function.hpp>

namespace momentree {

namespace {

constexpr std::size_t most_joints = 8;

// What an element does to one of its joints.
struct End {
  std::shared_ptr<const JointElement> element;
  std::shared_ptr<const std::vector<JointId>> joints;
  std::size_t place;

  double effort(const EvaluationContext& context) const noexcept {
    double q[most_joints], v[most_joints], efforts[most_joints] = {};
    const std::size_t count = joints->size();
    for (std::size_t k = 0; k < count; ++k) {
      // A joint that broke or was changed no longer has its function. Another joint with its number is none of the element's.
      const JointId joint = (*joints)[k];
      if (!context.has_function(joint) || context.q(joint).size() != 1) return 0;
      q[k] = context.q(joint)[0], v[k] = context.v(joint)[0];
    }
    with_kind(*element, [&](const auto& kind) { kind.efforts({q, count}, {v, count}, {efforts, count}); });
    return efforts[place];
  }
};

// The elements of a joint, as a function that drives it.
struct Acting {
  std::vector<End> ends;
  void operator()(const EvaluationContext& context, std::span<double> efforts) const {
    for (const End& end : ends) efforts[0] += end.effort(context);
  }
};

// Equal up to rounding: quaternions of a document are normalised when they are read.
bool same(double a, double b) { return std::fabs(a - b) <= 1e-12 * (1 + std::fabs(a)); }
bool same(const Vec3& a, const Vec3& b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }
bool same(const Pose& a, const Pose& b) {
  const Quat &r = a.rotation, &s = b.rotation;
  const double sign = r.w * s.w + r.x * s.x + r.y * s.y + r.z * s.z < 0 ? -1 : 1;
  return same(a.position, b.position) && same(r.w, sign * s.w) && same(Vec3{r.x, r.y, r.z}, sign * Vec3{s.x, s.y, s.z});
}

}  // namespace

// False for a joint that broke or was changed before the state was written that was restored.
bool World::as_in_the_model(JointId number) const {
  const int b = tree_.carrier(number.index);
  if (b < 0) return false;
  const Joint& now = tree_.joint(b);
  const BodySpec& then = model_[number];
  const BodyId inner{b}, outer{tree_.parent(b)};
  const bool reversed = tree_.reversed(b);
  return joint_name(number) == then.joint_name && (reversed ? outer : inner) == model_.child(number) &&
         (reversed ? inner : outer) == then.parent && now.kind == then.joint.kind && same(now.axis, then.joint.axis) &&
         now.pitch == then.joint.pitch && same(now.at, then.at) && same(now.child_at, then.child_at);
}

void World::attach_elements() {
  std::map<int, std::vector<End>> ends;  // a joint may have several
  for (const JointElement& element : model_.elements()) {
    const auto shared = std::make_shared<const JointElement>(element);
    const auto joints = std::make_shared<const std::vector<JointId>>(joints_of(element));
    MT_REQUIRE(joints->size() <= most_joints, "an element has at most 8 joints");
    // If one joint no longer exists, the others stay, as in a run: the element then has no effect.
    for (std::size_t k = 0; k < joints->size(); ++k)
      if (as_in_the_model((*joints)[k])) ends[(*joints)[k].index].push_back({shared, joints, k});
  }
  for (auto& [joint, acting] : ends) drive(joint, lasting(Acting{std::move(acting)}));
}

void end_elements(Tree& tree, JointId joint) {
  const std::vector<int> bodies(tree.joints_with().forces.begin(), tree.joints_with().forces.end());
  for (const int b : bodies) {
    const JointFunction* const now = tree.function(b);
    const LastingFunction* const there = is_lasting(now) ? now->target<LastingFunction>() : nullptr;
    const Acting* const acting = there == nullptr ? nullptr : there->lasting->target<Acting>();
    if (acting == nullptr) continue;
    const auto of_joint = [joint](const End& end) {
      return std::find(end.joints->begin(), end.joints->end(), joint) != end.joints->end();
    };
    if (std::none_of(acting->ends.begin(), acting->ends.end(), of_joint)) continue;
    Acting others = *acting;
    std::erase_if(others.ends, of_joint);
    tree.edit().set_function(b, std::make_shared<const JointFunction>(LastingFunction{
                                    std::make_shared<const JointFunction>(std::move(others)), there->replaceable}));
  }
}

}  // namespace momentree
