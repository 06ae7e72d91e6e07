#pragma once
// Functions on joints that stay when a user drives the joint, such as the spring of a coupling.
#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// A joint's function that Simulation::drive_all() does not replace: given to it, it is joined by functions that are set later.
/// The function of the joint then returns the sum of both. Like every function it ends when the joint breaks or becomes another.
struct LastingFunction {
  std::shared_ptr<const JointFunction> lasting;
  JointFunction replaceable{};  ///< empty: none

  void operator()(const EvaluationContext& context, std::span<double> efforts) const {
    (*lasting)(context, efforts);
    if (!replaceable) return;
    std::array<double, 6> more{};
    replaceable(context, std::span<double>(more).first(efforts.size()));
    for (std::size_t i = 0; i < efforts.size(); ++i) efforts[i] += more[i];
  }
};

/// The function to give to drive_all().
inline JointFunction lasting(JointFunction function) {
  return LastingFunction{std::make_shared<const JointFunction>(std::move(function))};
}

inline bool is_lasting(const JointFunction* function) {
  return function != nullptr && function->target<LastingFunction>() != nullptr;
}

/// What a joint with function `now` (null: none) gets when `function` (empty: none) is set.
inline JointFunction joined(const JointFunction* now, JointFunction function) {
  const LastingFunction* const there = is_lasting(now) ? now->target<LastingFunction>() : nullptr;
  if (const LastingFunction* const given = function.target<LastingFunction>()) {
    JointFunction kept = there != nullptr ? there->replaceable : now != nullptr ? *now : JointFunction();
    return LastingFunction{given->lasting, std::move(kept)};
  }
  return there == nullptr ? function : LastingFunction{there->lasting, std::move(function)};
}

}  // namespace momentree
