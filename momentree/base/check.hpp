#pragma once
// MT_REQUIRE(condition, "what was expected"): a programming error stops the program, in every build. Otherwise a topology change
// that reads a stale Workspace, for example, would silently give a wrong answer. Not for use inside kernels.

namespace momentree::detail {
[[noreturn]] void require_failed(const char* condition, const char* expected, const char* file, int line) noexcept;
}  // namespace momentree::detail

#define MT_REQUIRE(condition, expected) \
  ((condition) ? static_cast<void>(0) : ::momentree::detail::require_failed(#condition, expected, __FILE__, __LINE__))
