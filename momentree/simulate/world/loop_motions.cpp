// Prescribed motions of joints in loops have to be independent: each must move something that the others leave free.
#include <vector>

#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

JointParameters without_motion(JointParameters parameters) {
  parameters.drive = nullptr;
  return parameters;
}

struct Motions {
  const Tree& tree;
  const State& state;
  std::vector<JointId> joints{};
  int without = -1;  ///< number of a loop that is left out

  Motions(const Tree& all, const State& at) : tree(all), state(at) {
    for (const int b : tree.joints_with().motions) joints.push_back({tree.joint_of(b)});
    for (const Loop& loop : tree.loops())
      if (loop.driven()) joints.push_back(loop.id());
  }

  // A motion of the tree removes a column, one of a loop adds a row: if they are independent, the rank grows by the latter.
  bool independent(const std::vector<JointId>& kept) const {
    int rows = 0;
    for (const JointId joint : kept) rows += is_loop(joint) ? 1 : 0;
    return rank(kept) == rank({}) + rows;
  }

  int rank(const std::vector<JointId>& kept) const {
    Tree part = tree;
    if (without >= 0) part.edit().remove_loop(without);
    for (const JointId joint : joints) {
      bool keeps = false;
      for (const JointId each : kept) keeps = keeps || each == joint;
      if (keeps) continue;
      if (is_loop(joint)) {
        const Loop loop = *tree.loops().find(joint);
        part.edit().set_loop(loop.number, loop.joint, without_motion(loop.parameters), loop.held);
      } else {
        const int b = tree.carrier(joint).index;
        part.edit().set_parameters(b, without_motion(*tree.parameters(b)));
      }
    }
    Workspace<double> workspace(part);
    load_turns(part, state, workspace);
    return independent_rows(part, state.time(), state.q().data(), workspace);
  }
};

// The weld that holds what a motion would move, if a single one does; −1: none.
int holding_weld(Motions motions, const std::vector<JointId>& moved) {
  for (const Loop& loop : motions.tree.loops()) {
    if (loop.joint.kind != Kind::weld) continue;
    motions.without = loop.number;
    if (motions.independent(moved)) return loop.number;
  }
  return -1;
}

}  // namespace

std::optional<Error> conflicting_motions(const Tree& tree, const Names& names, const State& state) {
  if (!tree.has_loops() || tree.joints_with().motions.size() + static_cast<std::size_t>(tree.loops().motions) == 0)
    return std::nullopt;
  const Motions motions(tree, state);
  if (motions.independent(motions.joints)) return std::nullopt;
  const auto quoted = [&](JointId joint) { return "'" + names.joint(joint.index) + "'"; };
  std::vector<JointId> first;  // up to the first motion that is not independent of those before it
  do first.push_back(motions.joints[first.size()]);
  while (first.size() < motions.joints.size() && motions.independent(first));
  const JointId last = first.back();
  std::string others;
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    std::vector<JointId> rest = first;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    if (motions.independent(rest)) others += (others.empty() ? "" : " and ") + quoted(first[i]);
  }
  const std::string where = "joint " + quoted(last);
  constexpr const char* held = "its motion is prescribed, but loops and locks do not let it move here";
  if (const int weld = others.empty() ? holding_weld(motions, first) : -1; weld >= 0)
    return Error(held, where,
                 "weld " + quoted({first_loop + weld}) + " holds it: leave that out, or drive the joint by 'effort' or 'pd'");
  if (others.empty())
    return Error(held, where, "start away from a dead point, unlock a joint of the loop, or drive this one by 'effort' or 'pd'");
  return Error("its prescribed motion contradicts the one of " + others + ": through the loops, these joints move together",
               where, "leave out one of these motions, or drive that joint by 'effort' or 'pd'");
}

}  // namespace momentree
