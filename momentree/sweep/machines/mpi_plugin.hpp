#pragma once
// The interface between the program and momentree-mpi.so.
#include <cstddef>

namespace momentree::sweep {

inline constexpr int mpi_interface = 1;

extern "C" {
/// What momentree_plugin_mpi() returns. Messages are those of MPI_COMM_WORLD with one tag. send and receive may be called from
/// several threads. Functions that can fail return null, or a message that stays valid.
struct MomentreeMpi {
  int interface;        ///< mpi_interface
  const char* library;  ///< name and version of the MPI library
  const char* (*start)(int* rank, int* size);
  const char* (*send)(int to, const char* bytes, std::size_t size);
  /// The size of the next message and its sender; −1: there is none. take() must follow, by the same thread, and gets its bytes.
  long long (*probe)(int* from);
  void (*take)(int from, char* bytes, std::size_t size);
  void (*finish)();
  void (*abort)(int code);
};
}

}  // namespace momentree::sweep
