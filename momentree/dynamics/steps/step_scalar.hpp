#pragma once
// What a table of steps has to know of the scalar of its passes.
#include <array>
#include <cstddef>

#include <momentree/derive/step_arguments.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/variant.hpp>

namespace momentree {

inline constexpr std::size_t step_passes = 3;  ///< at most
using StepFunctions = std::array<StepFunction, step_passes>;

/// The generic functions of a kind as steps; each is called with a GenericBody as constants.
struct GenericStep {
  StepFunctions passes{};
  std::size_t record = 0;  ///< numbers of its record
};

/// Numbers of worlds that machine code computes at once.
enum class StepWidth : unsigned char { none, one, double_2, double_4, double_8, float_4, float_8, float_16 };

struct StepScalar {
  Passes passes = Passes::stage_velocities;
  std::size_t size = 0;                                ///< bytes
  void (*put)(void* to, double x) noexcept = nullptr;  ///< stores the same number for all worlds
  /// `adds`: inward, to the contributions of other children.
  GenericStep (*generic)(Kind kind, Variant variant, bool adds) noexcept = nullptr;
  StepWidth width = StepWidth::none;  ///< of machine code, where there is some
  StepFunctions interpreted{};        ///< carry out recorded steps, with an InterpretedStep as constants; null: they don't
};

}  // namespace momentree
