#include <cli/commit.hpp>

#include "command.hpp"

namespace momentree::python {

const char* commit() { return cli::commit; }

}  // namespace momentree::python
