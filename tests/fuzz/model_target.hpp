#pragma once
// Any text is either a model or refused with a diagnostic: nothing is thrown, nothing is read out of bounds. There is one target
// per format, because the beginning of an input decides how far it is read.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <tests/fuzz/judge.hpp>

namespace momentree::fuzz {

inline int read_model(const std::uint8_t* data, std::size_t size, const char* name) {
  judge(io::read_scenario_text({reinterpret_cast<const char*>(data), size}, name));
  return 0;
}

}  // namespace momentree::fuzz
