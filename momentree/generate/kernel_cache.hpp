#pragma once
// Kernels that are compiled while a simulation runs, one for each topology that it comes to (paper, section 2).
#include <memory>
#include <string>
#include <vector>

#include <momentree/dynamics/rates_function.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

struct KernelCacheOptions {
  /// The C++ compiler, with arguments if it needs some: a name in PATH or a path. Empty: what the environment says in
  /// MOMENTREE_CXX, else in CXX, else the first of c++, g++, clang++ in PATH.
  std::string compiler;
  /// Evaluations of more operations than that run the kernels themselves, which are then as fast; and a compiler would take long.
  long most_operations = 8000;
  /// So many topologies are compiled and no more: a world that is another one after every event would wait for nothing else.
  long most_topologies = 100;
};

/// What became of the topologies that a cache was asked for.
struct KernelCacheStatistics {
  long compiled = 0;     ///< topologies
  long found_again = 0;  ///< times that one came back
  long left = 0;  ///< topologies that run the kernels themselves: too large, too many; and asks where stages_take_rates is false
  long failed = 0;     ///< …, because the compiler failed
  double seconds = 0;  ///< for writing, compiling and loading
};

/// Code for every topology that it is asked for: written, compiled, loaded, and kept while the cache or a provider lives. What
/// counts is what the kernels read: forest, kinds, constants, gravity, rotors and locks, not dampers or springs. POSIX alone; the
/// compiler runs as a child process without a shell, in a directory of its own under TMPDIR that no other user can write to, and
/// which is gone when the code is loaded. Compiling happens at once, in the call: the same run gives the same bits every time.
/// Copies share what they have; safe to use from several threads.
class KernelCache {
 public:
  explicit KernelCache(KernelCacheOptions options = {});

  /// For Simulation::use_generated.
  RatesProvider provider() const;
  /// The code for what the tree is now, or null; see KernelCacheStatistics::left and message().
  RatesFunction find(const Tree& tree) const;

  KernelCacheStatistics statistics() const;
  /// Why topologies have no code although they should; empty: they have. The first reason stays.
  std::string message() const;
  /// The compiler with its arguments, as it is run; empty: none was found.
  std::vector<std::string> compiler() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace momentree
