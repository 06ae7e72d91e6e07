#pragma once
// A short list of numbers stored in place: one per DoF (at most 6) or one per coordinate (at most 7).
#include <array>
#include <initializer_list>

#include <momentree/base/check.hpp>

namespace momentree {

class Values {
 public:
  static constexpr int capacity = 7;

  constexpr Values() = default;
  constexpr Values(double value) : count_(1) { at_[0] = value; }  // NOLINT(google-explicit-constructor): .damping = 0.1
  Values(std::initializer_list<double> values) {
    for (double v : values) push_back(v);
  }
  void push_back(double value) {
    MT_REQUIRE(count_ < capacity, "at most 7 values");
    at_[static_cast<std::size_t>(count_++)] = value;
  }
  constexpr int size() const { return count_; }
  constexpr bool empty() const { return count_ == 0; }
  constexpr double operator[](int i) const { return at_[place(i)]; }
  constexpr double& operator[](int i) { return at_[place(i)]; }
  double* data() { return at_.data(); }
  const double* begin() const { return at_.data(); }
  const double* end() const { return at_.data() + count_; }
  bool any() const {
    for (double v : *this)
      if (v != 0) return true;
    return false;
  }
  /// The value of a DoF: a single number applies to every DoF; `none` if there is no value.
  double of(int dof, double none = 0) const {
    return count_ == 1 ? at_[0] : dof < count_ ? at_[static_cast<std::size_t>(dof)] : none;
  }
  friend bool operator==(const Values& a, const Values& b) {
    if (a.count_ != b.count_) return false;
    for (int i = 0; i < a.count_; ++i)
      if (a[i] != b[i]) return false;
    return true;
  }

 private:
  constexpr std::size_t place(int i) const {
    MT_REQUIRE(i >= 0 && i < count_, "an index below size()");
    return static_cast<std::size_t>(i);
  }
  std::array<double, capacity> at_{};
  int count_ = 0;
};

}  // namespace momentree
