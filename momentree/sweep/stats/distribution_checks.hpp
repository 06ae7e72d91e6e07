#pragma once
// Checks of the parameters of distributions: they throw Error, without a place. Included only by distribution.cpp and
// distribution_checks.cpp.
#include <momentree/sweep/stats/distribution.hpp>

namespace momentree::sweep {

void check_distribution(const Uniform& d);
void check_distribution(const Normal& d);
void check_distribution(const Lognormal& d);
void check_distribution(const Exponential& d);
void check_distribution(const Weibull& d);
void check_distribution(const Triangular& d);
void check_distribution(const Beta& d);
void check_distribution(const Choice& d);

}  // namespace momentree::sweep
