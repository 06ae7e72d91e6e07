#include <momentree/sweep/machines/mpi_communicator.hpp>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <thread>

#include <momentree/base/error.hpp>
#include <momentree/results/hdf5/plugin.hpp>
#include <momentree/sweep/machines/mpi_plugin.hpp>

namespace momentree::sweep {

using namespace std::chrono_literals;

namespace {

constexpr io::PluginInfo plugin = {"mpi", mpi_interface, "runs on several machines", "libopenmpi-dev",
                                   "sweeps with the threads of one machine work without it"};

class MpiCommunicator final : public Communicator {
 public:
  MpiCommunicator(const MomentreeMpi& mpi, int rank, int size) : mpi_(mpi), rank_(rank), size_(size) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void send(int to, std::string_view bytes) override {
    if (const char* const problem = mpi_.send(to, bytes.data(), bytes.size()); problem != nullptr)
      throw_error({std::string("cannot send to rank ") + std::to_string(to) + ": " + problem, "", ""});
  }

  // MPI would wait with a busy loop.
  std::optional<Message> receive(std::chrono::milliseconds timeout) override {
    const auto end = std::chrono::steady_clock::now() + timeout;
    for (std::chrono::microseconds pause = 20us;; pause = std::min<std::chrono::microseconds>(2 * pause, 8ms)) {
      Message message{};
      if (const long long size = mpi_.probe(&message.from); size >= 0) {
        message.bytes.resize(static_cast<std::size_t>(size));
        mpi_.take(message.from, message.bytes.data(), message.bytes.size());
        return message;
      }
      if (std::chrono::steady_clock::now() >= end) return std::nullopt;
      std::this_thread::sleep_for(pause);
    }
  }

  void finish() override { mpi_.finish(); }
  [[noreturn]] void abort(int code) override {
    mpi_.abort(code);
    std::_Exit(code);
  }

 private:
  const MomentreeMpi& mpi_;
  const int rank_, size_;
};

}  // namespace

std::unique_ptr<Communicator> connect_mpi(const Launch& launch) {
  const auto& mpi = *static_cast<const MomentreeMpi*>(io::load_plugin(plugin));
  int rank = 0, size = 1;
  if (const char* const problem = mpi.start(&rank, &size); problem != nullptr) throw_error({problem, "", ""});
  if (launch.size && *launch.size != size)
    throw_error({launch.variable + " says that " + std::to_string(*launch.size) + " processes were started, but MPI connects " +
                     std::to_string(size),
                 "",
                 "use the mpirun of the MPI library that momentree was built with, which is " +
                     std::string(mpi.library).substr(0, std::string(mpi.library).find(',')) + ", or `srun --mpi=pmix`"});
  if (size > 1) return std::make_unique<MpiCommunicator>(mpi, rank, size);
  mpi.finish();
  return nullptr;
}

}  // namespace momentree::sweep
