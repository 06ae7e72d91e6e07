#pragma once
#include <string>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// The first thing that is wrong with the syntax of a file.
struct SyntaxError {
  Place place;
  std::string what, hint;
  bool quotes = true;  ///< they may have words of the file
};

}  // namespace momentree::io
