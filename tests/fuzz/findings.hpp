#pragma once
// What a check found: broken laws, counts, and how near the others were to their tolerances.
#include <map>
#include <string>
#include <vector>

namespace momentree::fuzz {

/// Number of occurrences, by name.
using Counts = std::map<std::string, long>;

struct Findings {
  std::vector<std::string> broken;  ///< which law, and how it was violated
  Counts counts;
  std::map<std::string, double> worst;  ///< by law: the largest fraction of its tolerance
  void require(bool holds, const std::string& law, const std::string& detail = "") {
    if (!holds) broken.push_back(law + (detail.empty() ? "" : ": " + detail));
  }
  void within(double error, double tolerance, const std::string& law, const std::string& detail = "");
};

}  // namespace momentree::fuzz
