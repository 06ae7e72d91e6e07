#include <momentree/base/unique_number.hpp>

#include <atomic>

namespace momentree::detail {

std::uint64_t unique_number() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

}  // namespace momentree::detail
