#pragma once
// Laws that must hold for every scenario and its runs.
#include <map>
#include <string>
#include <vector>

#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/traced_run.hpp>

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

/// Reads the text, runs it in many ways, and checks the laws for the results. `choose` decides where runs are stopped.
void check_scenario(const std::string& text, Choices& choose, Findings& found);

}  // namespace momentree::fuzz
