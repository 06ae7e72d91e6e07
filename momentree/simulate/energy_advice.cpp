// The warning about an energy balance that does not close.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

namespace {

// Beyond this fraction of the largest kinetic energy the computed motion is not trusted.
constexpr double tolerated = 1e-3;
constexpr double tolerated_of_steps = 5e-2;  // where contacts were stepped through, which is of order 1
constexpr double rounding = 1e-12;

std::string formatted(const char* pattern, double a) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, pattern, a);
  return buffer;
}

// A fraction of the kinetic energy: "11 % of", "12 times".
std::string share_text(double share) {
  return share < 10 ? formatted("%.2g %% of", 100 * share) : formatted("%.0f times", share);
}

// What closing loops and contacts after the steps added or took, if that is a large part.
std::string advice_on_closing(double projection, double largest, double turned_over, const Integration& how) {
  if (!(std::fabs(projection) > std::max(tolerated * largest, rounding * turned_over))) return {};
  const bool adaptive = is_adaptive(how.method);
  return "closing loops and contacts after steps changed the energy by " + formatted("%.3g J", projection) + ", " +
         (largest > 0 ? share_text(std::fabs(projection) / largest) + " the largest kinetic energy"
                      : std::string("although nothing moves")) +
         ": steps are too long, or loops pass a position in which they are singular, such as a four-bar with all bars in line; "
         "use " +
         (adaptive ? "smaller tolerances, such as " + formatted("rtol = %.0e", how.rtol / 100)
                   : "a smaller step, such as " + formatted("%.3g s", how.step / 4) + ", or an adaptive method: dop853");
}

}  // namespace

std::string EnergyBalance::advice(const Integration& how) const {
  if (!std::isfinite(error) || !std::isfinite(initial) || !std::isfinite(final))
    return "the energies overflow: masses, lengths or speeds are too large";
  double turned_over = 0;  // its rounding is not an integration error
  for (const double part : {initial, final, work, dissipated, lost_in_impacts, released}) turned_over += std::fabs(part);
  const bool stepped = lost_in_steps != 0;
  const double most = (stepped ? tolerated_of_steps : tolerated) * largest_kinetic;
  if (stepped && !(std::fabs(projection) <= most))
    return "removing overlaps changed the energy by " + formatted("%.3g J", projection) + ", " +
           share_text(std::fabs(projection) / largest_kinetic) +
           " the largest kinetic energy: contacts were stepped through with too long steps; use a smaller step, such as " +
           formatted("%.3g s", how.step / 4);
  if (!(std::fabs(error) > std::max(most, rounding * turned_over)))
    return stepped ? std::string() : advice_on_closing(projection, largest_kinetic, turned_over, how);
  std::string what = "the energy balance is off by " + formatted("%.3g J", error) + ", " +
                     (largest_kinetic > 0 ? share_text(std::fabs(error) / largest_kinetic) + " the largest kinetic energy"
                                          : std::string("although nothing moves")) +
                     ": the motion is not computed accurately";
  if (stepped)
    return what + ", because contacts were stepped through; use a smaller step, such as " + formatted("%.3g s", how.step / 4);
  if (is_adaptive(how.method)) return what + "; use smaller tolerances, such as " + formatted("rtol = %.0e", how.rtol / 100);
  what += "; use a smaller step, such as " + formatted("%.3g s", how.step / 4);
  return how.method == "damped" ? what : what + ", or an adaptive method: dop853";
}

}  // namespace momentree
