#pragma once
// A value that its copies share until one of them changes.
#include <atomic>
#include <utility>

namespace momentree::detail {

/// Copies cost nothing; the first change of a shared one copies the value. Two copies may be used in two threads, like two
/// separate values.
template <class T>
class CopyOnWrite {
 public:
  CopyOnWrite() : shared_(new Shared) {}
  CopyOnWrite(const CopyOnWrite& other) noexcept : shared_(other.shared_) {
    shared_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  /// A moved-from object holds the value of the object that it was assigned to, or the same value.
  CopyOnWrite(CopyOnWrite&& other) noexcept : CopyOnWrite(std::as_const(other)) {}
  CopyOnWrite& operator=(CopyOnWrite other) noexcept {
    std::swap(shared_, other.shared_);
    return *this;
  }
  ~CopyOnWrite() {
    if (shared_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete shared_;
  }

  const T& operator*() const { return shared_->value; }
  const T* operator->() const { return &shared_->value; }
  /// Write access: makes the value this object's own.
  T& own() {
    if (shared_->owners.load(std::memory_order_acquire) != 1) *this = CopyOnWrite(shared_->value);
    return shared_->value;
  }

 private:
  struct Shared {
    T value{};
    std::atomic<int> owners{1};
  };
  explicit CopyOnWrite(const T& value) : shared_(new Shared{value}) {}
  Shared* shared_;
};

}  // namespace momentree::detail
