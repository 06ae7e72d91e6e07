#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/results/hdf5/hdf5_plugin.hpp>
#include <momentree/results/hdf5/plugin.hpp>
#include <momentree/text/files/system_file.hpp>
#include <momentree/text/files/table_file.hpp>

namespace momentree::io {

namespace {

constexpr PluginInfo hdf5_plugin = {"hdf5", hdf5_interface, "HDF5 files", "libhdf5-dev", "CSV files do not need it"};

/// The partial file, locked: made, or taken over from a process that was killed.
Descriptor lock_partial(const std::string& path) {
  for (int tries = 0; tries < 100; ++tries) {
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666));
    if (!file) fail_with_reason("cannot make this file", path, last_error());
    struct stat own {
    }, there{};
    if (::fstat(file.number(), &own) != 0) fail_with_reason("cannot access this file", path, last_error());
    char signature[4] = {};
    if (!S_ISREG(own.st_mode) ||
        (own.st_size > 0 && (::pread(file.number(), signature, 4, 0) != 4 || std::string_view(signature, 4) != "\x89HDF")))
      throw_error({"this is not a file of momentree, and would be replaced", path, "move it elsewhere"});
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EINTR) continue;
      if (errno == EWOULDBLOCK) throw_error({"another process is writing this file", path, "wait until it has ended"});
      if (errno != ENOSYS && errno != ENOLCK && errno != ENOTSUP) fail_with_reason("cannot lock this file", path, last_error());
    }
    // Otherwise the process that held the lock has completed it meanwhile.
    if (::lstat(path.c_str(), &there) == 0 && there.st_dev == own.st_dev && there.st_ino == own.st_ino) return file;
  }
  throw_error({"cannot lock this file", path, ""});
}

class Hdf5File final : public TableFile {
 public:
  explicit Hdf5File(const std::string& path)
      : api_(*static_cast<const MomentreeHdf5*>(load_plugin(hdf5_plugin))), path_(path), partial_(path + ".partial") {
    lock_ = lock_partial(partial_);
    MomentreeHdf5Problem problem{};
    file_ = api_.create(partial_.c_str(), &problem);
    if (file_ != nullptr) return;
    ::unlink(partial_.c_str());
    fail(problem);
  }
  ~Hdf5File() override {
    if (!lock_) return;
    ::unlink(partial_.c_str());  // first: it must not look complete
    close_quietly();
  }

  std::size_t add_table(const std::string& name, std::vector<TableColumn> columns) override {
    if (!name.empty()) call(api_.group, name.c_str());
    Table& table = tables_.emplace_back();
    table.group = name;
    constexpr std::size_t memory = 32u << 20, least = 16, most = 4096;
    table.chunk = std::clamp(memory / (8 * std::max<std::size_t>(columns.size(), 1)), least, most);
    const std::vector<std::string> paths = hdf5_paths(columns);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string path = name.empty() ? paths[i] : name + '/' + paths[i];
      if (const std::size_t slash = path.rfind('/'); slash != std::string::npos && slash > name.size())
        call(api_.group, path.substr(0, slash).c_str());
      const auto type = static_cast<int>(columns[i].type);
      table.columns.push_back({call(api_.dataset, path.c_str(), type, table.chunk), empty(columns[i].type)});
      if (!columns[i].unit.empty()) set(path, "unit", columns[i].unit);
      if (!columns[i].about.empty()) set(path, "about", columns[i].about);
    }
    set(name, "columns", paths);
    return tables_.size() - 1;
  }

  void append(std::size_t number, std::span<const ColumnValues> values) override {
    Table& table = tables_.at(number);
    MT_REQUIRE(values.size() == table.columns.size(), "an entry for each column");
    for (std::size_t i = 0; i < values.size(); ++i) {
      MT_REQUIRE(values[i].index() == table.columns[i].values.index(), "values of the column's type");
      const std::size_t rows = std::visit(
          [&](const auto& from) {
            auto& to = std::get<std::decay_t<decltype(from)>>(table.columns[i].values);
            to.insert(to.end(), from.begin(), from.end());
            return from.size();
          },
          values[i]);
      MT_REQUIRE(i == 0 || rows == table.added, "columns of equal length");
      table.added = rows;
    }
    table.waiting += table.added;
    if (table.waiting >= table.chunk) write_out(table, false);
  }

  void append_row(std::size_t number, std::span<const double> row) override {
    Table& table = tables_.at(number);
    MT_REQUIRE(row.size() == table.columns.size(), "an entry for each column");
    for (std::size_t i = 0; i < row.size(); ++i) std::get<std::vector<double>>(table.columns[i].values).push_back(row[i]);
    if (++table.waiting >= table.chunk) write_out(table, false);
  }

  void attribute(std::size_t table, const std::string& name, const AttributeValue& value) override {
    set(tables_.at(table).group, name, value);
  }
  void file_attribute(const std::string& name, const AttributeValue& value) override { set("", name, value); }

  void finish(bool to_disk) override {
    for (Table& table : tables_) write_out(table, true);
    MomentreeHdf5Problem problem{};
    if (api_.close(std::exchange(file_, nullptr), &problem) != 0) fail(problem);
    std::error_code error = to_disk ? sync(lock_) : std::error_code();
    if (!error && ::rename(partial_.c_str(), path_.c_str()) != 0) error = last_error();
    if (error) fail_with_reason("cannot finish writing", path_, error);
    if (to_disk) sync_folder(std::filesystem::path(path_).parent_path());
    lock_.close();
  }

 private:
  struct Column {
    int dataset;
    ColumnValues values;  ///< that are not in the file yet
  };
  struct Table {
    std::string group;
    std::size_t chunk = 0;               ///< rows
    std::size_t waiting = 0, added = 0;  ///< rows in `values`; of the last call
    std::vector<Column> columns;
  };

  static ColumnValues empty(TableColumn::Type type) {
    switch (type) {
      case TableColumn::Type::number: return std::vector<double>();
      case TableColumn::Type::flag: return std::vector<std::uint8_t>();
      case TableColumn::Type::text: return std::vector<std::string>();
      default: return std::vector<std::uint64_t>();
    }
  }

  [[noreturn]] void fail(const MomentreeHdf5Problem& problem) const {
    if (problem.system_error != 0)
      fail_with_reason("cannot write this file", path_, {problem.system_error, std::generic_category()});
    throw_error({std::string("cannot write this file: ") + problem.text, path_, ""});
  }
  template <class... Parameters, class... Arguments>
  int call(int (*function)(void*, Parameters...), const Arguments&... arguments) const {
    MomentreeHdf5Problem problem{};
    const int result = function(file_, arguments..., &problem);
    if (result < 0) fail(problem);
    return result;
  }
  void close_quietly() {
    MomentreeHdf5Problem ignored{};
    if (file_ != nullptr) api_.close(std::exchange(file_, nullptr), &ignored);
  }

  static std::vector<const char*> pointers(std::span<const std::string> texts) {
    std::vector<const char*> result;
    for (const std::string& text : texts) result.push_back(text.c_str());
    return result;
  }

  void set(const std::string& path, const std::string& name, const AttributeValue& value) {
    const auto one = [&](int type, const void* at) { call(api_.attribute, path.c_str(), name.c_str(), type, at); };
    if (const auto* const text = std::get_if<std::string>(&value)) {
      const char* const bytes = text->c_str();
      one(momentree_text, &bytes);
    } else if (const auto* const texts = std::get_if<std::vector<std::string>>(&value)) {
      call(api_.texts, path.c_str(), name.c_str(), pointers(*texts).data(), texts->size());
    } else if (const auto* const number = std::get_if<double>(&value)) {
      one(momentree_number, number);
    } else {
      one(momentree_count, &std::get<std::uint64_t>(value));
    }
  }

  // Whole chunks, and at the end the rest.
  void write_out(Table& table, bool all) {
    const std::size_t rows = all ? table.waiting : table.waiting / table.chunk * table.chunk;
    if (rows == 0) return;
    for (Column& column : table.columns)
      std::visit(
          [&](auto& values) {
            if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<std::string>>)
              call(api_.append, column.dataset, static_cast<const void*>(pointers({values.data(), rows}).data()), rows);
            else
              call(api_.append, column.dataset, static_cast<const void*>(values.data()), rows);
            values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rows));
          },
          column.values);
    table.waiting -= rows;
  }

  const MomentreeHdf5& api_;
  const std::string path_, partial_;
  Descriptor lock_;  ///< the partial file; none after finish()
  void* file_ = nullptr;
  std::vector<Table> tables_;
};

}  // namespace

void require_hdf5() { load_plugin(hdf5_plugin); }

std::optional<std::string> hdf5_text(const std::string& path, const std::string& name) {
  const MomentreeHdf5& api = *static_cast<const MomentreeHdf5*>(load_plugin(hdf5_plugin));
  std::optional<std::string> found;
  const auto take = [](void* context, const char* text) {
    try {
      *static_cast<std::optional<std::string>*>(context) = text;
    } catch (const std::bad_alloc&) {  // no exception may pass through the plugin
    }
  };
  if (api.file_text(path.c_str(), name.c_str(), take, &found) == 1 && !found) throw std::bad_alloc();
  return found;
}

std::unique_ptr<TableFile> make_hdf5_file(const std::string& path) { return std::make_unique<Hdf5File>(path); }

}  // namespace momentree::io
