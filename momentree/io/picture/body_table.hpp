#pragma once
// bodies.csv: poses of all bodies at chosen instants. The file is read as a stream, for it may be larger than the memory.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Column numbers of a body's pose.
struct PoseColumns {
  std::string name;
  std::array<std::size_t, 7> at{};  ///< x y z qw qx qy qz
};

class BodyTable {
 public:
  /// Reads the header and the times. Throws Error: missing file or columns, times that are no numbers.
  explicit BodyTable(std::filesystem::path file);

  const std::vector<PoseColumns>& bodies() const { return bodies_; }
  const std::vector<double>& times() const { return times_; }

  /// The row nearest to `time`; of several at one instant the last (after what happened then).
  std::size_t row_near(double time) const;
  /// The rows of these numbers (ascending). Throws Error: a short or long row, a field that is no finite number.
  std::vector<RecordedFrame> read(const std::vector<std::size_t>& rows) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<PoseColumns> bodies_;
  std::vector<double> times_;
};

/// The fields of one line of CSV (RFC 4180 quotes allowed).
std::vector<std::string> split_csv(const std::string& line);

/// The rows for one frame every `every` seconds, from the first row on; see read_recording for 0. Sets `every` to what it took.
std::vector<std::size_t> choose_rows(const BodyTable& table, double& every);

}  // namespace momentree::io
