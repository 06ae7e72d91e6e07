#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

template Workspace<double>::Workspace(const Tree& tree);

}  // namespace momentree
