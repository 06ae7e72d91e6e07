// Any text is either a state document of a model or refused with an Error: nothing else is thrown, and a simulation accepts the
// document or refuses it with a reason.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <tests/fuzz/judge.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace momentree;
  static const Model model = io::test::two_mechanisms();
  const std::string text(reinterpret_cast<const char*>(data), size);
  for (const char* mechanism : {"", "arm"}) {
    try {
      const std::vector<io::RestoredState> documents = {io::read_state(text, "fuzz.json", model, mechanism)};
      Simulation simulation(model);
      io::restore(simulation, documents);
      for (const Mechanism& each : simulation.world().mechanisms()) fuzz::require_visible(std::string(each.name));
    } catch (const Error& error) {
      fuzz::require_visible(error.message());
    }
  }
  return 0;
}
