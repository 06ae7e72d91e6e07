#pragma once
// Expressions as C++.
#include <string>
#include <string_view>

#include <momentree/generate/kernel.hpp>

namespace momentree {

/// How a kernel's file names and describes what it defines.
struct SourceText {
  std::string name = "kernel";  ///< all names begin with it; `identifier` leaves it as it is
  std::string about;            ///< lines for the comment at its head, without //; any text: see comment_text
};

/// A C++20 file by itself, which needs the standard library alone: `extern "C" void NAME_rates(const double* q, const double* p,
/// double* v, double* qdot, double* pdot)`, a RatesFunction of straight-line code, and its sizes `const int NAME_nq, NAME_nv`.
/// Sines and cosines are the engine's own. Constants are written so that they read back to the same bits.
std::string kernel_source(const KernelExpressions& kernel, const SourceText& how = {});

/// `name` as an identifier: what does not belong into one becomes _.
std::string identifier(std::string_view name);

}  // namespace momentree
