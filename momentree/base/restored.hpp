#pragma once
// Sets a value for the duration of a scope.

namespace momentree::detail {

/// Sets a value during its own lifetime and restores it afterwards.
template <class T>
class Restored {
 public:
  Restored(T& value, T now) : value_(value), before_(value) { value = now; }
  ~Restored() { value_ = before_; }
  Restored(const Restored&) = delete;
  Restored& operator=(const Restored&) = delete;

 private:
  T& value_;
  T before_;
};

}  // namespace momentree::detail
