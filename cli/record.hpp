#pragma once
// Runs a scenario for a picture only: the results are written to a temporary folder.
#include <string>

#include <momentree/io/scenario.hpp>

namespace momentree::cli {

/// A folder that is removed by the destructor.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string result() const { return file("result"); }
  std::string file(const std::string& name) const { return path_ + '/' + name; }

 private:
  std::string path_;
};

struct Recorded {
  std::string folder;  ///< contains the results, complete or not
  int code = 0;        ///< exit code of the run; errors have been reported
};

/// The results needed: those for a picture, or everything in the report, including joint reactions and energy.
enum class Purpose { picture, report };

/// Runs a scenario into a folder.
Recorded record(const io::Scenario& scenario, const std::string& folder, Purpose purpose);

}  // namespace momentree::cli
