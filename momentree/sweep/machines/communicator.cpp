#include <momentree/sweep/machines/communicator.hpp>

namespace momentree::sweep {

Communicator::~Communicator() = default;

}  // namespace momentree::sweep
