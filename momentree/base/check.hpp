#pragma once
// MT_REQUIRE(condition, "what was expected"): a developer's mistake stops the program, in every build:
// a stale Work read by a topology change gives a wrong answer silently otherwise. Not for use inside kernels.

namespace momentree::detail {
[[noreturn]] void require_failed(const char* condition, const char* expected, const char* file, int line) noexcept;
}  // namespace momentree::detail

#define MT_REQUIRE(condition, expected) \
  ((condition) ? static_cast<void>(0) : ::momentree::detail::require_failed(#condition, expected, __FILE__, __LINE__))
