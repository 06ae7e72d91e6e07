#include <momentree/base/check.hpp>

#include <cstdio>
#include <cstdlib>

namespace momentree::detail {

void require_failed(const char* condition, const char* expected, const char* file, int line) noexcept {
  std::fprintf(stderr, "%s:%d: momentree was used wrongly: %s (%s)\n", file, line, expected, condition);
  std::abort();
}

}  // namespace momentree::detail
