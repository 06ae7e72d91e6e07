#pragma once
// The rows of contacts.csv, which runs with reactions have if bodies can touch.
#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// `time` (s), the names of both bodies, then point (m), normal, force on the first body (N) and speed of slip (m/s); world axes.
void contact_header(std::string& text);
/// A row for each point at which bodies touch; none if none do.
void contact_rows(std::string& text, const World& world);

/// Of these columns, those of numbers.
inline constexpr std::array<const char*, 10> contact_column_names = {"point.x",  "point.y", "point.z", "normal.x", "normal.y",
                                                                     "normal.z", "force.x", "force.y", "force.z",  "slip"};
inline constexpr std::array<const char*, 10> contact_column_units = {"m", "m", "m", "", "", "", "N", "N", "N", "m/s"};
/// A row of contacts.csv.
struct ContactCells {
  double time = 0;
  std::string one, other;
  std::array<double, contact_column_names.size()> numbers{};
};
/// Reads contacts.csv, row by row. A last line without an end is left out. Throws Error: a file that is not one.
void for_each_contact(const std::filesystem::path& file, const std::function<void(const ContactCells&)>& visit);

}  // namespace momentree::io
