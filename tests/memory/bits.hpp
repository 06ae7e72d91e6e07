#pragma once
#include <cstring>
#include <vector>

#include <momentree/math/spatial.hpp>

namespace momentree::memory {

/// Numbers that a function found, to be compared to the last bit.
class Bits {
 public:
  void add(const double* numbers, int count) { all_.insert(all_.end(), numbers, numbers + count); }
  void add(double number) { all_.push_back(number); }
  void add(const Vec3& a) { add(a.x), add(a.y), add(a.z); }
  void add(const Motion<double>& a) { add(a.v), add(a.w); }
  void add(const Force<double>& a) { add(a.l), add(a.h); }
  friend bool operator==(const Bits& a, const Bits& b) {
    return a.all_.size() == b.all_.size() && std::memcmp(a.all_.data(), b.all_.data(), a.all_.size() * sizeof(double)) == 0;
  }

 private:
  std::vector<double> all_;
};

}  // namespace momentree::memory
