// Any bytes are either a checkpoint or refused with an Error, also where length and checksum are right. A checkpoint that fits a
// simulation can be continued from; the world is then one whose parts can be asked for.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <momentree/base/error.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/checksum.hpp>
#include <tests/fuzz/judge.hpp>

namespace {

using namespace momentree;

Simulation prepared() {
  Simulation simulation(io::test::two_mechanisms());
  simulation.at(0.01).then(break_joint("arm/wrist"));
  simulation.at(0.02).then(set_parameters("pendulum", {.damping = 0.25}));
  simulation.when(speed_of("pendulum").exceeds(100)).then(lock("pendulum"));
  return simulation;
}

void append(std::string& bytes, std::uint64_t n) {
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(n >> (8 * i) & 255);
}

// The data as the content of a whole checkpoint.
std::string sealed(std::string_view data) {
  static const std::string head = io::checkpoint_bytes({}).substr(0, 19);  // magic number and format
  std::string bytes = head;
  append(bytes, data.size());
  bytes += data;
  io::Checksum checksum;
  checksum.add(bytes);
  append(bytes, checksum.value());
  return bytes;
}

void judge_bytes(std::string_view bytes) {
  try {
    io::Checkpoint checkpoint = io::read_checkpoint(bytes, "checkpoint");
    fuzz::require(io::checkpoint_bytes(checkpoint) == bytes);
    Simulation simulation = prepared();
    checkpoint.run.world.engine.topology.model = simulation.world().tree().topology().model;  // differs from CPU to CPU
    io::require_fit(simulation, checkpoint, "checkpoint");
    io::continue_run(simulation, checkpoint);
    fuzz::require(simulation.world().mechanisms().size() <= 4 && simulation.events().size() == checkpoint.run.events.size());
  } catch (const Error& error) {
    fuzz::require_visible(error.message());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  judge_bytes(bytes);
  judge_bytes(sealed(bytes));
  return 0;
}
