#include <tests/fuzz/model_target.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return momentree::fuzz::read_model(data, size, "fuzz.sdf");
}
