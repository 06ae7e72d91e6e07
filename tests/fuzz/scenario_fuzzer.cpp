// Any text is either a scenario or refused with a diagnostic: nothing is thrown, nothing is read out of bounds.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <tests/fuzz/judge.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // The text after a form feed is an override: both are parsed into the same document.
  const std::size_t cut = text.find('\f');
  std::vector<std::string> overrides;
  if (cut != std::string_view::npos) overrides.emplace_back(text.substr(cut + 1));
  momentree::fuzz::judge(momentree::io::read_scenario_text(text.substr(0, cut), "fuzz.toml", overrides));
  return 0;
}
