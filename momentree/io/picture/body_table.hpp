#pragma once
// bodies.csv: poses of all bodies at chosen instants.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/io/number_table.hpp>
#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Column indices of a body's pose, without `time`.
struct PoseColumns {
  std::string name;
  std::array<std::size_t, 7> at{};  ///< x y z qw qx qy qz
};
/// Throws Error: columns that are missing, occur twice or belong to no pose.
std::vector<PoseColumns> find_bodies(const NumberTable& table);

class BodyTable : public NumberTable {
 public:
  /// Reads the header and the times. Throws Error as NumberTable and find_bodies() do, and for a table without rows.
  explicit BodyTable(const std::filesystem::path& file);

  const std::vector<PoseColumns>& bodies() const { return bodies_; }

  /// The row nearest to `time` (s); of several at one instant the last (after the events of that instant).
  std::size_t row_near(double time) const;
  /// The rows with these indices (ascending). Throws Error: a short or long row, a field that is not a finite number.
  std::vector<RecordedFrame> frames(const std::vector<std::size_t>& rows) const;

 private:
  std::vector<PoseColumns> bodies_;
};

/// The rows for one frame every `every` seconds, beginning with the first row; see read_recording for 0. Sets `every` to the
/// value used.
std::vector<std::size_t> choose_rows(const BodyTable& table, double& every);

}  // namespace momentree::io
