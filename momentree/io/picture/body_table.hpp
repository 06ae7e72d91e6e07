#pragma once
// bodies.csv: poses of all bodies at chosen instants. The file is read as a stream, since it may be larger than memory.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Column indices of a body's pose.
struct PoseColumns {
  std::string name;
  std::array<std::size_t, 7> at{};  ///< x y z qw qx qy qz
};

class BodyTable {
 public:
  /// Reads the header and the times. Throws Error: missing file or columns, times that are not numbers.
  explicit BodyTable(std::filesystem::path file);

  const std::vector<PoseColumns>& bodies() const { return bodies_; }
  const std::vector<double>& times() const { return times_; }

  /// The row nearest to `time` (s); of several at one instant the last (after the events of that instant).
  std::size_t row_near(double time) const;
  /// The rows with these indices (ascending). Throws Error: a short or long row, a field that is not a finite number.
  std::vector<RecordedFrame> read(const std::vector<std::size_t>& rows) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<PoseColumns> bodies_;
  std::vector<double> times_;
};

/// The fields of one line of CSV (RFC 4180 quotes allowed).
std::vector<std::string> split_csv(const std::string& line);

/// The rows for one frame every `every` seconds, beginning with the first row; see read_recording for 0. Sets `every` to the
/// value used.
std::vector<std::size_t> choose_rows(const BodyTable& table, double& every);

}  // namespace momentree::io
