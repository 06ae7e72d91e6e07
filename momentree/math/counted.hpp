#pragma once
// A counting scalar: the kernels run on it as on double, so that their operation counts are known and can be held to budgets.
#include <cmath>

namespace momentree {

/// Operations by the usual accounting: a change of sign is free, and so is a product or sum of constants of the model.
struct Operations {
  long additions = 0, multiplications = 0, divisions = 0;
  long sincos = 0;  ///< pairs of a sine and a cosine
  long total() const { return additions + multiplications + divisions; }
};

class Counted {
 public:
  Counted() = default;
  Counted(double value) : value_(value) {}  // NOLINT(google-explicit-constructor): constants of the model
  double value() const { return value_; }
  /// Operations of this thread on such scalars since this was last set to {}.
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
