#pragma once
// Files with tables in columns: HDF5.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace momentree::io {

struct TableColumn {
  enum class Type {
    number,  ///< double; NaN: missing
    flag,    ///< 0 or 1
    text,    ///< UTF-8 without null bytes
    count    ///< uint64
  };
  std::string name;  ///< unique in its table
  Type type = Type::number;
  std::string unit{};   ///< "m/s"; empty: none
  std::string about{};  ///< what it is; may be empty
};

/// The values of a column, in the alternative of its type: number, flag, text or count.
using ColumnValues =
    std::variant<std::vector<double>, std::vector<std::uint8_t>, std::vector<std::string>, std::vector<std::uint64_t>>;
using AttributeValue = std::variant<std::string, double, std::uint64_t, std::vector<std::string>>;

/// A file that appears under its name when it is complete; until then it is PATH.partial. The same calls make the same bytes. All
/// functions throw Error if the file cannot be written; nothing but the destructor may be called after that.
class TableFile {
 public:
  TableFile() = default;
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  /// Without finish(): removes what was written.
  virtual ~TableFile();

  /// Adds a table without rows. `name`: of its group; empty: the root of the file. Returns its number: 0, 1, ….
  virtual std::size_t add_table(const std::string& name, std::vector<TableColumn> columns) = 0;
  /// Appends rows: an entry for each column, all of the same length.
  virtual void append(std::size_t table, std::span<const ColumnValues> columns) = 0;
  /// Appends one row to a table that only has columns of numbers.
  virtual void append_row(std::size_t table, std::span<const double> row) = 0;
  /// Describes the table; `file_attribute` the whole file.
  virtual void attribute(std::size_t table, const std::string& name, const AttributeValue& value) = 0;
  virtual void file_attribute(const std::string& name, const AttributeValue& value) = 0;
  /// Completes the file and gives it its name; a file of that name is replaced. `to_disk`: waits until it is on the disk.
  virtual void finish(bool to_disk = true) = 0;
};

/// An HDF5 file, readable by HDF5 1.10 and later: a group for each table, with one dataset for each column, named like it,
/// compressed and with checksums except for texts. The dataset's attributes `unit` and `about` are those of the column, and the
/// group's attribute `columns` lists the names in order. Flags have the type that h5py reads as bool. A '/' in a name makes
/// groups within the group, so that the name is the path of the dataset; it becomes %2F if that is impossible ("a//b"). Throws
/// Error if momentree-hdf5.so is missing, if the file cannot be made, or if another process is writing it.
[[nodiscard]] std::unique_ptr<TableFile> make_hdf5_file(const std::string& path);

/// Throws Error if momentree-hdf5.so is missing or unusable.
void require_hdf5();

/// An attribute of a whole HDF5 file, as file_attribute() writes texts; nothing if there is no such file or attribute. Throws
/// Error if momentree-hdf5.so is missing.
[[nodiscard]] std::optional<std::string> hdf5_text(const std::string& path, const std::string& name);

/// The paths of columns within their group: see make_hdf5_file().
std::vector<std::string> hdf5_paths(std::span<const TableColumn> columns);

}  // namespace momentree::io
