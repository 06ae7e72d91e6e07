#pragma once
// Messages of Foxglove as JSON: transforms, scenes and log lines.
#include <cstdint>
#include <string>
#include <string_view>

#include <momentree/export/drawing.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io::foxglove {

/// `{"sec": …, "nsec": …}` of a time in nanoseconds.
void write_time(JsonWriter& json, const char* key, std::uint64_t time);

std::string frame_transforms(const Drawing& drawing, std::size_t row, std::uint64_t time, const std::string& world);

/// The solids of all bodies that have colours of their own, or of those that have not.
enum class Solids { own_colours, mechanism_colours };
/// An entity for each body that has any; they replace those of the same bodies. Empty if there are none.
std::string scene(const Drawing& drawing, Solids which, const Colouring& colouring, std::uint64_t time);
/// The bars of a row, as lines.
std::string bars(const Drawing& drawing, std::size_t row, std::uint64_t time, const std::string& world);

enum class Level { debug = 1, info = 2, error = 4 };
std::string log(Level level, std::string_view name, std::string_view message, std::uint64_t time);

}  // namespace momentree::io::foxglove
