#pragma once
// A value for a scope.

namespace momentree::detail {

/// A value that is another one for as long as this lives.
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
