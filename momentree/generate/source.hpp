#pragma once
// Expressions as C++ source.
#include <string>
#include <string_view>

#include <momentree/generate/kernel.hpp>

namespace momentree {

/// Name and description of a kernel's file.
struct SourceText {
  std::string name = "kernel";  ///< prefix of all names; must be an identifier, see `identifier`
  std::string about;            ///< lines for the comment at the top, without //; any text: see comment_text
};

/// A self-contained C++20 file that needs only the standard library: for momenta `extern "C" void NAME_rates(const double* q,
/// const double* p, double* v, double* qdot, double* pdot)`, a RatesFunction of straight-line code, for velocities `extern "C"
/// void NAME_accelerations(const double* q, const double* u, const double* tau, double* qdot, double* udot)`, a
/// VelocityRatesFunction; and its sizes `const int NAME_nq, NAME_nv`. Sines and cosines are the engine's own. Constants are
/// written so that they read back to the same bits.
std::string kernel_source(const KernelExpressions& kernel, const SourceText& how = {});

/// `name` as an identifier: invalid characters are replaced by _.
std::string identifier(std::string_view name);

}  // namespace momentree
