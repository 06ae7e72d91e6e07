#pragma once
// The report that `momentree run` prints at its end.
#include <string>

#include <cli/text.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::cli {

struct RunReport {
  std::string title;  ///< of the scenario, or its name
  Integration integration;
  double start = 0;  ///< s
  int dofs = 0;      ///< at the start
};

/// Timings as in the paper's Table 2, the events with their conserved quantities, the energy balance.
std::string report_text(const RunReport& report, const Simulation& simulation, const Style& style);

}  // namespace momentree::cli
