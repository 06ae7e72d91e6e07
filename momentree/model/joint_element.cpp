#include <momentree/model/joint_element.hpp>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <momentree/model/model.hpp>

namespace momentree {

namespace {

// Calls visit(key, member, field) with each member of an element.
template <class Visit>
void each_member(const JointElement& element, Visit visit) {
  with_kind(element, [&visit](const auto& kind) { describe(visit, kind); });
}

const char* outside(double x, Range range) {
  if (!std::isfinite(x)) return "must be finite";
  if (range == Range::positive && !(x > 0)) return "must be positive";
  if (range == Range::not_negative && x < 0) return "must not be negative";
  if (range == Range::fraction && !(x >= 0 && x <= 1)) return "must be from 0 to 1";
  return nullptr;
}

}  // namespace

std::vector<JointId> joints_of(const JointElement& element) {
  std::vector<JointId> all;
  each_member(element, [&all](const char*, const auto& member, const Field&) {
    if constexpr (Like<std::decay_t<decltype(member)>, JointId>) all.push_back(member);
  });
  return all;
}

JointElement with_joints(JointElement element, const std::function<JointId(JointId)>& now) {
  const auto change = [&now](const char*, auto& member, const Field&) {
    if constexpr (std::is_same_v<std::decay_t<decltype(member)>, JointId>) member = now(member);
  };
  std::visit(
      [&change](auto& kind) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(kind)>, std::monostate>) describe(change, kind);
      },
      element);
  return element;
}

std::vector<ElementProblem> check_element(const JointElement& element, const Model& model) {
  std::vector<ElementProblem> problems;
  if (joints_of(element).empty()) return {{"element", "has no joints", "give one of the kinds in momentree/model/elements"}};
  std::vector<JointId> before;
  each_member(element, [&](const char* key, const auto& member, const Field& field) {
    const auto problem = [&](std::string what, std::string hint) { problems.push_back({key, std::move(what), std::move(hint)}); };
    using Member = std::decay_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, double>) {
      if (const char* const what = outside(member, field.range)) problem(what, "");
    } else if constexpr (std::is_same_v<Member, JointId>) {
      if (is_loop(member)) return problem("a joint that closes a loop can't be coupled", "name a joint of the tree");
      if (member.index < 0 || member.index >= model.size())
        return problem("is not a joint of this model", "give the joint of a body that was added before");
      if (std::find(before.begin(), before.end(), member) != before.end())
        problem("names a joint that the element has already", "name another one of the same world");
      before.push_back(member);
      const BodySpec& spec = model[member];
      if (info(spec.joint.kind).nv != 1)
        problem("joint '" + spec.joint_name + "' is " + std::string(info(spec.joint.kind).name) +
                    ", and does not have one degree of freedom",
                "name revolute, prismatic and helical joints");
      else if (spec.joint.parameters.drive && spec.joint.parameters.drive->moves())
        problem("the motion of joint '" + spec.joint_name + "' is prescribed",
                "drive it by position control: drive = { pd = { … } }");
    }
  });
  return problems;
}

}  // namespace momentree
