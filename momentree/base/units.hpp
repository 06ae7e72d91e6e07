#pragma once
// Numbers with units, as scenarios write them: "0.83 g cm^2", "1e-5 N m s", "30 deg", "9.81 m/s^2".
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
inline constexpr Dimension frequency = number / time;  // turns or events per second: no radians
inline constexpr Dimension inertia = mass * length * length, force = mass * acceleration, torque = force * length;
}  // namespace dimension

/// "an angle (rad)", "a damping (N m s/rad)" …: the name of a dimension with its SI unit.
std::string name_of(const Dimension& dimension);
/// How a value of that dimension is written, for hints: `0.5, or "50 cm"`; `1.5` where it has no unit.
std::string example_of(const Dimension& dimension);

/// What could not be read: what is wrong and how to mend it.
struct QuantityProblem {
  std::string what, hint;
};

/// A number with units in SI, where it has the dimension `expected`; else nothing, and `problem` says why. Radians may be left
/// out beside mass ("N m" for "N m/rad"). Decimal units cost no accuracy: "5 cm" is the double nearest to 0.05. Any locale.
std::optional<double> parse_quantity(std::string_view text, const Dimension& expected, QuantityProblem& problem);

}  // namespace momentree
