#pragma once
// The source of a generator's choices: a seed, or the bytes of a fuzzer. After the last byte every choice is the first one, so
// that generation ends for every input.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include <tests/oracle/prng.hpp>

namespace momentree::fuzz {

class Choices {
 public:
  /// Prng traverses all its seeds in one cycle, where neighbouring seeds are one draw apart: seeds are therefore mixed first.
  explicit Choices(std::uint64_t seed) : random_(oracle::Prng(seed).next()), by_seed_(true) {}
  explicit Choices(std::span<const std::uint8_t> bytes) : random_(0), bytes_(bytes) {}

  /// In [low, high].
  int integer(int low, int high) {
    if (by_seed_) return random_.integer(low, high);
    return low + static_cast<int>(next(2) % static_cast<std::uint64_t>(high - low + 1));
  }
  /// In [0, 1).
  double unit() { return by_seed_ ? random_.unit() : static_cast<double>(next(2)) * 0x1p-16; }
  bool chance(double probability) {
    return by_seed_ ? random_.chance(probability) : static_cast<double>(next(1)) < 256 * probability - 1;
  }
  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[static_cast<std::size_t>(integer(0, static_cast<int>(from.size()) - 1))];
  }
  std::string word(std::vector<std::string> from) { return pick(from); }

  /// A number as text with three digits: the same on every machine.
  std::string number(double low, double high) {
    const double value = low + (high - low) * unit();
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
  }
  /// A positive number of an order of magnitude in [low, high], as text.
  std::string magnitude(int low, int high) {
    const std::string digits = word({"1", "1.5", "2", "3", "5", "7"});
    return digits + "e" + std::to_string(integer(low, high));
  }
  std::string vector(double size) {
    const std::string x = number(-size, size), y = number(-size, size), z = number(-size, size);
    return "[" + x + ", " + y + ", " + z + "]";
  }
  std::string axis() {
    if (chance(0.6)) return word({"[0, 0, 1]", "[1, 0, 0]", "[0, 1, 0]"});
    return "[" + number(0.1, 1) + ", " + number(-1, 1) + ", " + number(-1, 1) + "]";
  }

 private:
  std::uint64_t next(int count) {
    std::uint64_t value = 0;
    for (; count > 0 && at_ < bytes_.size(); --count) value = value << 8 | bytes_[at_++];
    return value;
  }

  oracle::Prng random_;
  bool by_seed_ = false;
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace momentree::fuzz
