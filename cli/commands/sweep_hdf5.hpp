#pragma once
// A sweep's results as one HDF5 file.
#include <memory>
#include <string>
#include <vector>

#include <momentree/sweep/results.hpp>
#include <momentree/text/files/table_file.hpp>

namespace momentree::cli {

/// The table `worlds`, and `outcome/done`, which tells what is absent from what is false. All functions throw Error.
class SweepTable {
 public:
  /// Makes a file without rows. Without finish() it is removed. The sweep must outlive this object.
  SweepTable(const sweep::Sweep& sweep, const std::string& path);
  /// Adds the next world.
  void add(const sweep::Row& row);
  /// Completes the file. `summary`: the text of sweep.json.
  void finish(const std::string& summary);

 private:
  void clear();
  void write();

  const sweep::Sweep& sweep_;
  const std::vector<sweep::ParameterColumn> varied_;
  std::vector<io::TableColumn> columns_;
  std::unique_ptr<io::TableFile> file_;
  std::size_t worlds_ = 0, outcome_ = 0;  ///< tables
  std::vector<io::ColumnValues> values_;
  std::vector<std::uint8_t> done_;
};

/// The text of sweep.json in an HDF5 file of a sweep; empty if the file is none. Throws Error if momentree-hdf5.so is missing.
std::string summary_in(const std::string& path);
/// Throws Error if there is something at `path` that is not the HDF5 file of a sweep, and would be replaced.
void require_replaceable(const std::string& path);

}  // namespace momentree::cli
