#include <tests/fuzz/findings.hpp>

#include <cstdio>

namespace momentree::fuzz {

void Findings::within(double error, double tolerance, const std::string& law, const std::string& detail) {
  double& most = worst[law];
  const double share = error / tolerance;
  if (!(share <= most)) most = share;
  char text[160];
  std::snprintf(text, sizeof text, " (%.3e > %.3e)", error, tolerance);
  require(error <= tolerance, law, detail + text);
}

}  // namespace momentree::fuzz
