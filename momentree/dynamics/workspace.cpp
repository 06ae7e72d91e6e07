#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

StepScalar detail::double_steps(Passes passes) {
  if (in_momenta(passes)) return double_momenta(keeps_results(passes));
  return in_velocities(passes) ? double_velocities(keeps_results(passes)) : double_accelerations(passes == Passes::solutions);
}

template Workspace<double>::Workspace(const Tree& tree);

}  // namespace momentree
