// momentree-hdf5.so: tables in HDF5 files.
#include <hdf5.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <momentree/results/hdf5/hdf5_plugin.hpp>

using namespace momentree::io;

namespace {

/// A handle of HDF5, closed by the destructor.
class Handle {
 public:
  Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), close_(closer) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() { close(); }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): for calls of HDF5
  bool close() {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

struct Dataset {
  Handle handle;
  hid_t type;
  hsize_t rows;
};

struct File {
  Handle handle, text, flag;
  std::vector<Dataset> datasets;
};

// The innermost entry of HDF5's error stack says what happened: "… errno = 28, error message = 'No space left on device' …".
herr_t note_entry(unsigned, const H5E_error2_t* entry, void* data) {
  auto& problem = *static_cast<MomentreeHdf5Problem*>(data);
  if (entry->desc == nullptr) return 0;
  if (problem.text[0] == '\0') std::snprintf(problem.text, sizeof problem.text, "%s", entry->desc);
  const char* const number = std::strstr(entry->desc, "errno = ");
  if (number != nullptr && problem.system_error == 0) std::sscanf(number, "errno = %d", &problem.system_error);
  return 0;
}

/// Thrown within this module when HDF5 reports a failure.
struct Failed {
  MomentreeHdf5Problem problem{};
  /// Reads HDF5's error stack, which the next call would clear.
  Failed() {
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, note_entry, &problem);
    if (problem.text[0] == '\0') std::snprintf(problem.text, sizeof problem.text, "HDF5 gives no reason");
  }
};

template <class Number>
Number require(Number result) {
  if (result < 0) throw Failed();
  return result;
}

/// Calls an action, which returns a result or throws, and describes a failure.
template <class Result, class Action>
Result guarded(MomentreeHdf5Problem* problem, Result failed, const Action& action) noexcept {
  *problem = {};
  try {
    return action();
  } catch (const Failed& failure) {
    *problem = failure.problem;
  } catch (const std::bad_alloc&) {
    std::snprintf(problem->text, sizeof problem->text, "out of memory");
  }
  return failed;
}

Handle properties(hid_t list) { return {require(H5Pcreate(list)), H5Pclose}; }

Handle text_type() {
  Handle type(require(H5Tcopy(H5T_C_S1)), H5Tclose);
  require(H5Tset_size(type, H5T_VARIABLE));
  require(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

// As h5py stores bool.
Handle flag_type() {
  Handle type(require(H5Tenum_create(H5T_NATIVE_INT8)), H5Tclose);
  const signed char no = 0, yes = 1;
  require(H5Tenum_insert(type, "FALSE", &no));
  require(H5Tenum_insert(type, "TRUE", &yes));
  return type;
}

hid_t type_of(const File& file, int type) {
  switch (type) {
    case momentree_number: return H5T_NATIVE_DOUBLE;
    case momentree_count: return H5T_NATIVE_UINT64;
    case momentree_flag: return file.flag;
    default: return file.text;
  }
}

Handle open_object(const File& file, const char* path) {
  return {require(H5Oopen(file.handle, *path == '\0' ? "/" : path, H5P_DEFAULT)), H5Oclose};
}

void* create(const char* path, MomentreeHdf5Problem* problem) {
  return guarded(problem, static_cast<void*>(nullptr), [&]() -> void* {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // prints nothing
    const Handle access = properties(H5P_FILE_ACCESS), creation = properties(H5P_FILE_CREATE);
    require(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
    require(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
    require(H5Pset_file_locking(access, false, true));  // the program has locked it
    require(H5Pset_obj_track_times(creation, false));
    Handle text = text_type(), flag = flag_type();
    return new File{
        Handle(require(H5Fcreate(path, H5F_ACC_TRUNC, creation, access)), H5Fclose), std::move(text), std::move(flag), {}};
  });
}

// Groups above it are made, too, all with their members in the order of creation.
int group(void* file, const char* path, MomentreeHdf5Problem* problem) {
  return guarded(problem, -1, [&] {
    const Handle creation = properties(H5P_GROUP_CREATE), link = properties(H5P_LINK_CREATE);
    require(H5Pset_obj_track_times(creation, false));
    require(H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
    require(H5Pset_char_encoding(link, H5T_CSET_UTF8));
    const std::string whole = path;
    for (std::size_t end = 0; end != std::string::npos;) {
      end = whole.find('/', end + 1);
      const std::string part = whole.substr(0, end);
      if (require(H5Lexists(static_cast<File*>(file)->handle, part.c_str(), H5P_DEFAULT)) > 0) continue;
      const Handle made(require(H5Gcreate2(static_cast<File*>(file)->handle, part.c_str(), link, creation, H5P_DEFAULT)),
                        H5Gclose);
    }
    return 0;
  });
}

int dataset(void* file, const char* path, int type, std::size_t rows_per_chunk, MomentreeHdf5Problem* problem) {
  return guarded(problem, -1, [&] {
    File& own = *static_cast<File*>(file);
    const hsize_t none = 0, unlimited = H5S_UNLIMITED, chunk = rows_per_chunk;
    const Handle space(require(H5Screate_simple(1, &none, &unlimited)), H5Sclose);
    const Handle creation = properties(H5P_DATASET_CREATE), access = properties(H5P_DATASET_ACCESS);
    const Handle link = properties(H5P_LINK_CREATE);
    require(H5Pset_obj_track_times(creation, false));
    require(H5Pset_chunk(creation, 1, &chunk));
    if (type != momentree_text) {  // HDF5 has no filters for texts of any length
      require(H5Pset_shuffle(creation));
      if (H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0) require(H5Pset_deflate(creation, 1));
      require(H5Pset_fletcher32(creation));
    }
    require(H5Pset_char_encoding(link, H5T_CSET_UTF8));
    require(H5Pset_chunk_cache(access, 1, 0, 1));  // whole chunks are written
    const hid_t stored = type_of(own, type);
    own.datasets.reserve(own.datasets.size() + 1);
    own.datasets.push_back(
        {Handle(require(H5Dcreate2(own.handle, path, stored, space, link, creation, access)), H5Dclose), stored, 0});
    return static_cast<int>(own.datasets.size()) - 1;
  });
}

int append(void* file, int number, const void* values, std::size_t rows, MomentreeHdf5Problem* problem) {
  return guarded(problem, -1, [&] {
    Dataset& own = static_cast<File*>(file)->datasets[static_cast<std::size_t>(number)];
    const hsize_t first = own.rows, count = rows, all = own.rows + rows;
    require(H5Dset_extent(own.handle, &all));
    const Handle there(require(H5Dget_space(own.handle)), H5Sclose),
        here(require(H5Screate_simple(1, &count, nullptr)), H5Sclose);
    require(H5Sselect_hyperslab(there, H5S_SELECT_SET, &first, nullptr, &count, nullptr));
    require(H5Dwrite(own.handle, own.type, here, there, H5P_DEFAULT, values));
    own.rows = all;
    return 0;
  });
}

void write_attribute(const File& file, const char* path, const char* name, hid_t type, const Handle& space, const void* value) {
  const Handle object = open_object(file, path), creation = properties(H5P_ATTRIBUTE_CREATE);
  require(H5Pset_char_encoding(creation, H5T_CSET_UTF8));
  const Handle made(require(H5Acreate2(object, name, type, space, creation, H5P_DEFAULT)), H5Aclose);
  require(H5Awrite(made, type, value));
}

int attribute(void* file, const char* path, const char* name, int type, const void* value, MomentreeHdf5Problem* problem) {
  return guarded(problem, -1, [&] {
    const File& own = *static_cast<File*>(file);
    write_attribute(own, path, name, type_of(own, type), {require(H5Screate(H5S_SCALAR)), H5Sclose}, value);
    return 0;
  });
}

int texts(void* file, const char* path, const char* name, const char* const* values, std::size_t size,
          MomentreeHdf5Problem* problem) {
  return guarded(problem, -1, [&] {
    const File& own = *static_cast<File*>(file);
    const hsize_t count = size;
    write_attribute(own, path, name, own.text, {require(H5Screate_simple(1, &count, nullptr)), H5Sclose}, values);
    return 0;
  });
}

// A file that could not be written remains open within HDF5, which would try to write it again at the end of the program.
int close(void* file, MomentreeHdf5Problem* problem) {
  const std::unique_ptr<File> own(static_cast<File*>(file));
  return guarded(problem, -1, [&] {
    for (Dataset& each : own->datasets)
      if (!each.handle.close()) throw Failed();
    if (!own->handle.close()) throw Failed();
    return 0;
  });
}

// Only texts as this module writes them: of variable length.
int file_text(const char* path, const char* name, void (*take)(void*, const char*), void* context) {
  MomentreeHdf5Problem ignored;
  return guarded(&ignored, 0, [&] {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // prints nothing
    const Handle access = properties(H5P_FILE_ACCESS);
    require(H5Pset_file_locking(access, false, true));
    const Handle file(require(H5Fopen(path, H5F_ACC_RDONLY, access)), H5Fclose);
    if (require(H5Aexists(file, name)) == 0) return 0;
    const Handle attribute(require(H5Aopen(file, name, H5P_DEFAULT)), H5Aclose), text = text_type();
    const Handle type(require(H5Aget_type(attribute)), H5Tclose), space(require(H5Aget_space(attribute)), H5Sclose);
    if (H5Tis_variable_str(type) <= 0 || H5Sget_simple_extent_type(space) != H5S_SCALAR) return 0;
    char* found = nullptr;
    require(H5Aread(attribute, text, static_cast<void*>(&found)));
    if (found != nullptr) take(context, found);
    const bool there = found != nullptr;
    H5free_memory(found);
    return there ? 1 : 0;
  });
}

const char* library_version() {
  static char text[32] = "";
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  std::snprintf(text, sizeof text, "HDF5 %u.%u.%u", major, minor, release);
  return text;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const void* momentree_plugin_hdf5() {
  [[maybe_unused]] static const herr_t no_exit_handler = H5dont_atexit();
  static const MomentreeHdf5 table = {hdf5_interface, library_version(), create, group, dataset,
                                      append,         attribute,         texts,  close, file_text};
  return &table;
}
