#pragma once
#include <momentree/math/vec.hpp>

namespace momentree {

/// Pose of a body's kernel frame in its user frame. `R`: kernel axes to user axes; `r`: the kernel frame's origin (m).
struct KernelFrame {
  Mat3 R = identity3<double>();
  Vec3 r{};
};

}  // namespace momentree
