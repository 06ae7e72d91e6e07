#pragma once
// Statistics of a finished sweep: sweep.json, and the document of its report page.
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/sweep/results.hpp>
#include <momentree/sweep/stats/statistics.hpp>
#include <momentree/sweep/sweep.hpp>

namespace momentree::sweep {

/// The worlds with the most extreme values of a measure.
struct Worst {
  std::string measure;
  bool greatest = true;
  std::vector<Extreme> worlds;
};

/// The file name of the page that shows the motion of one world, beside the report: "world-401.html".
std::string page_of_world(std::uint64_t world);

class SweepSummary {
 public:
  /// The sweep must outlive this object.
  explicit SweepSummary(const Sweep& sweep);

  /// What finished worlds were computed by before changes were accepted: listed in the documents.
  void set_former(std::vector<FormerIdentity> former) { former_ = std::move(former); }
  /// Adds a world. Each is added once.
  void add(const Row& row);
  std::uint64_t done() const { return done_; }
  std::uint64_t failed() const { return failed_; }
  /// For each measure with numbers, the worlds with the least and the greatest values: at most `count` each.
  std::vector<Worst> worst(std::size_t count) const;
  /// The text of sweep.json: the same for the same results, whatever computed them.
  std::string json() const;
  /// The document of the report page: the above with the values of at most 20,000 worlds, a uniform sample. `animated`: the
  /// worlds that have a page of their own: page_of_world().
  std::string report(const std::vector<std::uint64_t>& animated) const;
  /// A line for each measure, for the terminal: name and text.
  std::vector<std::vector<std::string>> table() const;

 private:
  struct Failure {
    std::uint64_t world;
    std::string why;
  };
  std::string name(std::size_t column) const;
  std::string document(bool with_values, const std::vector<std::uint64_t>& animated) const;
  void write_column(io::JsonWriter& json, std::size_t column, const std::vector<double>& sample) const;
  void write_sensitivities(io::JsonWriter& json, const std::vector<std::vector<double>>& sample) const;
  void write_values(io::JsonWriter& json, const std::vector<std::vector<double>>& sample) const;
  void write_worst(io::JsonWriter& json, const std::vector<std::uint64_t>& animated) const;

  const Sweep& sweep_;
  std::vector<ParameterColumn> columns_;
  Statistics statistics_;
  std::vector<FormerIdentity> former_;
  std::uint64_t done_ = 0, failed_ = 0;
  std::vector<Failure> failures_;  ///< the first ones
};

}  // namespace momentree::sweep
