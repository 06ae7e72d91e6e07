#pragma once
// What must hold of every scenario and its runs.
#include <map>
#include <string>
#include <vector>

#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/traced_run.hpp>

namespace momentree::fuzz {

/// How often things came about, by their names.
using Counts = std::map<std::string, long>;

struct Findings {
  std::vector<std::string> broken;  ///< which law, and how
  Counts counts;
  std::map<std::string, double> worst;  ///< by law: the largest share of its tolerance
  void require(bool holds, const std::string& law, const std::string& detail = "") {
    if (!holds) broken.push_back(law + (detail.empty() ? "" : ": " + detail));
  }
  void within(double error, double tolerance, const std::string& law, const std::string& detail = "");
};

/// Reads the text, runs it in many ways, and holds the laws against what comes of it. `choose` says where it is stopped.
void check_scenario(const std::string& text, Choices& choose, Findings& found);

}  // namespace momentree::fuzz
