#pragma once
#include <string>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// The first syntax error of a file.
struct SyntaxError {
  Place place;
  std::string what, hint;
  bool quotes = true;  ///< `what` and `hint` may quote the file
};

}  // namespace momentree::io
