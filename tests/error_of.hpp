#pragma once
// The message of the Error that a call throws.
#include <functional>
#include <string>

#include <momentree/base/error.hpp>

namespace momentree {

/// Empty if nothing is thrown.
inline std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

}  // namespace momentree
