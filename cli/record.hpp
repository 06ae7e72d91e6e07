#pragma once
// A scenario that is run for its picture alone: its results stand in a temporary folder.
#include <string>

#include <momentree/io/scenario.hpp>

namespace momentree::cli {

/// A folder that is gone with it.
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
  std::string folder;  ///< with the results, whole or not
  int code = 0;        ///< exit code of the run; what went wrong has been said
};

/// What a picture needs, or all that the report shows: with the reactions of joints and the energy.
enum class Purpose { picture, report };

/// Runs a scenario into a folder. `until`: only so far (s).
Recorded record(const io::Scenario& scenario, const std::string& folder, double until, Purpose purpose);

}  // namespace momentree::cli
