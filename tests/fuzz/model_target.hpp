// Any text is either a model or refused with a diagnostic: nothing is thrown, nothing is read out of bounds. One target for each
// format, because what an input begins with decides how far it gets.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <momentree/io/scenario.hpp>

namespace momentree::fuzz {

inline int read_model(const std::uint8_t* data, std::size_t size, const char* name) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const io::ReadResult result = io::read_scenario_text(text, name);
  if (result.scenario.has_value() == io::has_errors(result.diagnostics)) std::abort();
  if (!io::rendered(result.diagnostics).empty() == result.diagnostics.empty()) std::abort();
  if (result.scenario && result.scenario->shapes.size() != static_cast<std::size_t>(result.scenario->model.size())) std::abort();
  return 0;
}

}  // namespace momentree::fuzz
