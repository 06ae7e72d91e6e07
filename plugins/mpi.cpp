// momentree-mpi.so: messages between the ranks of a sweep by MPI.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <climits>
#include <list>
#include <mutex>
#include <new>
#include <string>

#include <momentree/sweep/machines/mpi_plugin.hpp>

namespace {

constexpr int tag = 1;

struct Pending {
  std::string bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};

// MPI itself is one for each process.
struct State {
  std::mutex mutex;
  std::list<Pending> pending;  // messages that MPI has not sent completely
  MPI_Message probed = MPI_MESSAGE_NULL;
};

State& state() {
  static State the_state;
  return the_state;
}

void release_sent(State& s) {
  for (auto it = s.pending.begin(); it != s.pending.end();) {
    int done = 0;
    MPI_Test(&it->request, &done, MPI_STATUS_IGNORE);
    it = done != 0 ? s.pending.erase(it) : std::next(it);
  }
}

// Errors of MPI end all ranks, with MPI's message: its default.
const char* start(int* rank, int* size) {
  int provided = MPI_THREAD_SINGLE;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS) return "MPI cannot be started";
  if (provided < MPI_THREAD_SERIALIZED) return "this MPI library does not support threads";
  MPI_Comm_rank(MPI_COMM_WORLD, rank);
  MPI_Comm_size(MPI_COMM_WORLD, size);
  return nullptr;
}

const char* send(int to, const char* bytes, std::size_t size) {
  if (size > INT_MAX) return "a message is larger than 2 GiB";
  State& s = state();
  const std::lock_guard lock(s.mutex);
  try {
    s.pending.push_back({std::string(bytes, size)});
  } catch (const std::bad_alloc&) {
    return "out of memory";
  }
  Pending& last = s.pending.back();
  MPI_Isend(last.bytes.data(), static_cast<int>(size), MPI_BYTE, to, tag, MPI_COMM_WORLD, &last.request);
  release_sent(s);
  return nullptr;
}

long long probe(int* from) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  release_sent(s);
  int found = 0;
  MPI_Status status;
  MPI_Improbe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &found, &s.probed, &status);
  if (found == 0) return -1;
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  *from = status.MPI_SOURCE;
  return size;
}

// The sender has begun to send: waiting is short.
void take(int, char* bytes, std::size_t size) {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  MPI_Mrecv(bytes, static_cast<int>(size), MPI_BYTE, &s.probed, MPI_STATUS_IGNORE);
}

void finish() {
  State& s = state();
  const std::lock_guard lock(s.mutex);
  for (Pending& message : s.pending) MPI_Wait(&message.request, MPI_STATUS_IGNORE);
  s.pending.clear();
  MPI_Finalize();
}

void abort_all(int code) { MPI_Abort(MPI_COMM_WORLD, code); }

const char* library_version() {
  static char text[MPI_MAX_LIBRARY_VERSION_STRING + 1] = "";
  int size = 0;
  MPI_Get_library_version(text, &size);
  return text;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const void* momentree_plugin_mpi() {
  static const momentree::sweep::MomentreeMpi table = {
      momentree::sweep::mpi_interface, library_version(), start, send, probe, take, finish, abort_all};
  return &table;
}
