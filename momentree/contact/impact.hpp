#pragma once
// The impact law: impulses at simultaneous contacts that cannot increase the kinetic energy.
//
// Compression is the plastic impact with Coulomb friction. Expansion returns of each normal impulse N_c at least s e N_c
// (Poisson), again with friction, where s is the largest number in [0, 1], to 1e-6, with which neither the work of the
// expansion's normal impulses exceeds e² times that of the compression (Stronge) nor the kinetic energy after the impact exceeds
// the one before. s = 0 always does: the expansion is then zero, and the plastic impact loses energy. s < 1 is rare and reported.
#include <cstddef>
#include <vector>

#include <momentree/contact/system.hpp>

namespace momentree::contact {

/// How simultaneous contacts share an impact.
enum class Simultaneous : unsigned char {
  together,  ///< one impact at all points
  in_turn    ///< point by point, the one that approaches fastest first, until none approaches; after 1000 impacts for each
             ///< point the rest together, without restitution
};

struct ImpactResult {
  bool solved = true;      ///< false: no solution was found; r is then not to be used
  bool separated = false;  ///< no solution for all points together was found: they were taken in turn
  double scale = 1;        ///< s
};

/// Computes the impulses of an impact. The system holds A, b = the velocities before, and the friction of each point.
class ImpactLaw {
 public:
  /// Writes the impulses of all points to system.r. `restitution`: e of each point, from 0 to 1.
  ImpactResult apply(System& system, const std::vector<double>& restitution, Simultaneous how = Simultaneous::together);

 private:
  ImpactResult together(System& system, const std::vector<double>& restitution);
  ImpactResult in_turn(System& system, const std::vector<double>& restitution);
  bool expand(const System& compressed, const std::vector<double>& restitution, double s);
  bool fits(double most_work, double energy_lost, double tolerance) const;

  System expansion_, single_;
  std::vector<double> before_, after_, compression_, total_, best_, velocity_, one_restitution_;
};

}  // namespace momentree::contact
