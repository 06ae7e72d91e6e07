#pragma once

namespace momentree {

/// Handle of a body and of its inboard joint: each body has exactly one.
struct Body {
  int index = -1;
  friend bool operator==(Body, Body) = default;
};
/// The ground, as a parent.
inline constexpr Body ground{-1};

}  // namespace momentree
