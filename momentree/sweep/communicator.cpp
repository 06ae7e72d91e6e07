#include <momentree/sweep/communicator.hpp>

namespace momentree::sweep {

Communicator::~Communicator() = default;

}  // namespace momentree::sweep
