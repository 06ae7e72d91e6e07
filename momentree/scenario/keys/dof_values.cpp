#include <momentree/scenario/keys/dof_values.hpp>

#include <cmath>

namespace momentree::io {

std::optional<double> read_extended(const Value& value, const Dimension& expected, bool infinite, std::string_view label,
                                    Diagnostics& out) {
  if (const double* x = value.real(); infinite && x && std::isinf(*x)) return *x;
  return read_number(value, expected, label, out);
}

Values read_values(const Value& value, Quantity quantity, std::string_view letters, bool single, std::string_view label,
                   Diagnostics& out, bool infinite) {
  Values values;
  if (!value.array()) {
    if (single || letters.size() == 1) {
      // One number for DoFs of different dimensions is in SI units for each; with a unit it must fit all of them.
      std::optional<double> number;
      const std::string_view all = letters.empty() ? std::string_view("r") : letters;
      for (std::size_t i = 0; i < all.size(); ++i) {
        const char letter = all[i];
        if (all.find(letter) < i) continue;
        number = read_extended(value, dimension_of(quantity, letter), infinite, label, out);
        if (!number) return {};
      }
      values.push_back(*number);
      return values;
    }
    out.error(value.place, std::string(label) + ": expected a list of " + std::to_string(letters.size()) + " numbers, found " +
                               value.type_name());
    return {};
  }
  const Value::Array& entries = *value.array();
  if (entries.size() != letters.size() && !(single && entries.size() == 1)) {
    out.error(value.place,
              std::string(label) + ": expected " + std::to_string(letters.size()) +
                  (letters.size() == 1 ? " number" : " numbers") + ", found a list of " + std::to_string(entries.size()),
              "one per degree of freedom or coordinate, in the order of the joint kind");
    return {};
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto number = read_extended(entries[i], dimension_of(quantity, letters[i]), infinite, label, out);
    if (!number) return {};
    values.push_back(*number);
  }
  return values;
}

}  // namespace momentree::io
