#pragma once
// A scalar that counts: the kernels run on it as they run on double, so that their operations are known, and are held to budgets.
#include <cmath>

namespace momentree {

/// Operations of the usual accounting: a change of sign is free, so is a product or a sum of constants of the model.
struct Operations {
  long additions = 0, multiplications = 0, divisions = 0;
  long sincos = 0;  ///< pairs of sine and cosine
  long total() const { return additions + multiplications + divisions; }
};

class Counted {
 public:
  Counted() = default;
  Counted(double value) : value_(value) {}  // NOLINT(google-explicit-constructor): constants of the model
  double value() const { return value_; }
  /// What this thread did with such scalars since it was last set to {}.
  static Operations& operations() {
    thread_local Operations all;
    return all;
  }

  friend Counted operator+(Counted a, Counted b) { return ++operations().additions, a.value_ + b.value_; }
  friend Counted operator-(Counted a, Counted b) { return ++operations().additions, a.value_ - b.value_; }
  friend Counted operator*(Counted a, Counted b) { return ++operations().multiplications, a.value_ * b.value_; }
  friend Counted operator/(Counted a, Counted b) { return ++operations().divisions, a.value_ / b.value_; }
  friend Counted operator-(Counted a) { return -a.value_; }
  friend Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
  friend Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
  friend Counted& operator*=(Counted& a, Counted b) { return a = a * b; }
  friend void sincos(const Counted& x, Counted& s, Counted& c) {
    ++operations().sincos;
    s = std::sin(x.value_), c = std::cos(x.value_);
  }

 private:
  double value_;
};

}  // namespace momentree
