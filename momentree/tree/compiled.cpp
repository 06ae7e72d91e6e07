// The tree of a model, compiled once.
#include <atomic>
#include <memory>

#include <momentree/model/model.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace detail {

class CompiledOnce {
 public:
  CompiledOnce() = default;
  CompiledOnce(const CompiledOnce&) = delete;
  CompiledOnce& operator=(const CompiledOnce&) = delete;
  ~CompiledOnce() { delete tree_.load(); }

  bool empty() const { return tree_.load() == nullptr; }
  /// Several threads may compile it at once: the first one's tree stays.
  const Tree& of(const Model& model) {
    if (const Tree* const known = tree_.load()) return *known;
    auto made = std::make_unique<const Tree>(model);
    const Tree* first = nullptr;
    return tree_.compare_exchange_strong(first, made.get()) ? *made.release() : *first;
  }

 private:
  std::atomic<const Tree*> tree_ = nullptr;
};

std::shared_ptr<CompiledOnce> not_compiled() { return std::make_shared<CompiledOnce>(); }

void forget(std::shared_ptr<CompiledOnce>& compiled) {
  bool stays = compiled != nullptr && compiled.use_count() == 1;
  std::atomic_thread_fence(std::memory_order_acquire);  // a copy that has ended may have compiled it
  stays = stays && compiled->empty();
  if (!stays) compiled = not_compiled();
}

}  // namespace detail

const Tree& Model::compiled() const& {
  MT_REQUIRE(compiled_ != nullptr, "a model that was not moved from");
  return compiled_->of(*this);
}

}  // namespace momentree
