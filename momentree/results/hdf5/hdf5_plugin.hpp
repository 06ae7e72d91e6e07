#pragma once
// The interface between the program and momentree-hdf5.so.
#include <cstddef>
#include <cstdint>

namespace momentree::io {

inline constexpr int hdf5_interface = 2;

extern "C" {
/// Why a call failed.
struct MomentreeHdf5Problem {
  int system_error;  ///< errno; 0 if unknown
  char text[256];
};

/// Types of columns and attributes: double, uint8_t (an enumeration FALSE, TRUE), const char*, uint64_t.
enum MomentreeHdf5Type { momentree_number, momentree_flag, momentree_text, momentree_count };

/// What momentree_plugin_hdf5() returns. Functions return -1, and null, if they fail. Calls for one file must not overlap, nor
/// those for different files.
struct MomentreeHdf5 {
  int interface;        ///< hdf5_interface
  const char* library;  ///< name and version of the HDF5 library
  /// Overwrites an existing file.
  void* (*create)(const char* path, MomentreeHdf5Problem* problem);
  /// Makes a group, and those above it that do not exist. `path`: from the root, without a '/' at the beginning.
  int (*group)(void* file, const char* path, MomentreeHdf5Problem* problem);
  /// Makes an empty dataset and returns its number: 0, 1, ….
  int (*dataset)(void* file, const char* path, int type, std::size_t rows_per_chunk, MomentreeHdf5Problem* problem);
  /// Appends `rows` values of the dataset's type.
  int (*append)(void* file, int dataset, const void* values, std::size_t rows, MomentreeHdf5Problem* problem);
  /// An attribute of the object at that path ("" is the root): one value, or a list of `size` texts.
  int (*attribute)(void* file, const char* path, const char* name, int type, const void* value, MomentreeHdf5Problem* problem);
  int (*texts)(void* file, const char* path, const char* name, const char* const* values, std::size_t size,
               MomentreeHdf5Problem* problem);
  /// Writes everything and closes the file, in any case.
  int (*close)(void* file, MomentreeHdf5Problem* problem);
  /// Passes on an attribute of the root of an existing file that is one text without null bytes: calls `take` once and returns 1.
  /// 0: the file or the attribute cannot be read as that.
  int (*file_text)(const char* path, const char* name, void (*take)(void* context, const char* text), void* context);
};
}

}  // namespace momentree::io
