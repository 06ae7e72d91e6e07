#pragma once
#include <cstddef>

namespace momentree::contact {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace momentree::contact
