#pragma once
// Special functions of distributions, accurate to about 1e-15 (normal) and 1e-13 (beta).

namespace momentree::sweep {

/// The standard normal distribution: probability of values <= x. Accurate in both tails for small results.
double normal_cdf(double x);
/// Its inverse, 0 < p < 1.
double normal_quantile(double p);

/// The beta distribution with shapes a, b > 0: probability of values <= x, where y = 1 - x.
double beta_cdf(double a, double b, double x, double y);
/// Its inverse, 0 < p < 1: x, and 1 - x as `y`.
struct BetaPoint {
  double x, y;
};
BetaPoint beta_quantile(double a, double b, double p);

/// Variance of x^k / mean(x^k)² of an exponential variable x: Γ(1 + 2k) / Γ(1 + k)² - 1, k > 0.
double gamma_variance(double k);

}  // namespace momentree::sweep
