#pragma once
// Numbers with units, as in scenario files: "0.83 g cm^2", "1e-5 N m s", "30 deg", "9.81 m/s^2".
#include <optional>
#include <string>
#include <string_view>

namespace momentree {

/// Exponents of metre, kilogram, second and radian.
struct Dimension {
  int m = 0, kg = 0, s = 0, rad = 0;
  friend constexpr bool operator==(const Dimension&, const Dimension&) = default;
  friend constexpr Dimension operator*(const Dimension& a, const Dimension& b) {
    return {a.m + b.m, a.kg + b.kg, a.s + b.s, a.rad + b.rad};
  }
  friend constexpr Dimension operator/(const Dimension& a, const Dimension& b) {
    return {a.m - b.m, a.kg - b.kg, a.s - b.s, a.rad - b.rad};
  }
};

namespace dimension {
inline constexpr Dimension number{}, length{.m = 1}, mass{.kg = 1}, time{.s = 1}, angle{.rad = 1};
inline constexpr Dimension speed = length / time, angular_speed = angle / time, acceleration = speed / time;
inline constexpr Dimension frequency = number / time;  // revolutions or events per second: no radians
inline constexpr Dimension inertia = mass * length * length, force = mass * acceleration, torque = force * length;
}  // namespace dimension

/// The name of a dimension with its SI unit: "an angle (rad)", "a damping (N m s/rad)" …
std::string name_of(const Dimension& dimension);
/// Its SI unit alone: "N m s/rad"; empty for a number without one.
std::string unit_of(const Dimension& dimension);
/// An example value of that dimension, for hints: `0.5, or "50 cm"`; `1.5` if it has no unit.
std::string example_of(const Dimension& dimension);

/// Why a quantity could not be read, and how to correct it.
struct QuantityProblem {
  std::string what, hint;
};

/// Reads a number with units, in SI; empty if it does not have the dimension `expected`, and `problem` then gives the reason.
/// Radians may be omitted next to mass ("N m" for "N m/rad"). Decimal units cost no accuracy: "5 cm" is the double nearest to
/// 0.05. Independent of the locale.
std::optional<double> parse_quantity(std::string_view text, const Dimension& expected, QuantityProblem& problem);

struct WrittenQuantity {
  double number = 0;
  std::string unit;  ///< as written, without spaces around it
};
/// The parts of a number with a known unit: "0.5 ms" has 0.5 and "ms". Nothing for any other text.
std::optional<WrittenQuantity> split_quantity(std::string_view text);

}  // namespace momentree
