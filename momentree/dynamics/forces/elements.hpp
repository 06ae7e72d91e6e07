#pragma once
// All force elements of a joint except springs, dampers, constant efforts and functions.
#include <momentree/dynamics/forces/effort.hpp>
#include <momentree/dynamics/forces/friction.hpp>
#include <momentree/dynamics/forces/position_control.hpp>
#include <momentree/dynamics/forces/soft_stop.hpp>

namespace momentree::forces {

/// Adds their forces. `resisting` false: without those of resistance.hpp.
inline void add_elements(const Site& site, bool resisting = true) noexcept {
  const JointParameters& p = site.parameters;
  if (resisting && p.friction.any()) add_friction(site);
  if (resisting && p.limits.soft()) add_soft_stop(site);
  if (p.drive == nullptr) return;
  if (!p.drive->effort.empty()) add_efforts(site, *p.drive);
  if (resisting && p.drive->pd.any()) add_position_control(site, p.drive->pd);
}

}  // namespace momentree::forces
