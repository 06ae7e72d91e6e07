#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <momentree/sweep/stats/special_functions.hpp>

namespace momentree::sweep {
namespace {

constexpr double log_two_pi = 1.8378770664093454836;

// log Γ(n + 1) minus Stirling's formula (n + 1/2) log n - n + log(2π)/2. C. Loader, "Fast and accurate computation of binomial
// probabilities" (2000).
double stirling_error(double n) {
  double sum = 0;
  for (; n < 12; ++n) sum += (n + 0.5) * std::log1p(1 / n) - 1;
  constexpr std::array<double, 8> series{1.0 / 12,   -1.0 / 360,      1.0 / 1260, -1.0 / 1680,
                                         1.0 / 1188, -691.0 / 360360, 1.0 / 156,  -3617.0 / 122400};
  const double square = 1 / (n * n);
  double tail = 0;
  for (std::size_t i = series.size(); i-- > 0;) tail = tail * square + series[i];
  return sum + tail / n;
}

// a log(a/m) + m - a, without cancellation where a is near m; `difference` is a - m.
double deviance(double a, double m, double difference) {
  const double t = difference / m;
  if (std::abs(t) > 0.1) return a * std::log(a / m) - difference;
  // m ((1 + t) log(1 + t) - t) = m Σ (-t)^k / (k (k - 1)), k >= 2
  double sum = 0;
  for (int k = 18; k >= 2; --k) sum = sum * -t + 1.0 / (k * (k - 1));
  return m * t * t * sum;
}

// Shapes of a beta distribution.
struct Shapes {
  double a, b, constant;
  Shapes(double the_a, double the_b) : a(the_a), b(the_b) {
    const double n = a + b;
    constant =
        stirling_error(n) - stirling_error(a) - stirling_error(b) + 0.5 * (std::log(a) + std::log(b) - std::log(n) - log_two_pi);
  }
  Shapes(const Shapes& other, bool mirrored)
      : a(mirrored ? other.b : other.a), b(mirrored ? other.a : other.b), constant(other.constant) {}
  // log of x^a y^b Γ(a + b) / (Γ(a) Γ(b))
  double log_kernel(double x, double y) const {
    const double n = a + b, difference = a * y - b * x;  // a - n x = n y - b
    return constant - deviance(a, n * x, difference) - deviance(b, n * y, -difference);
  }
};

// The continued fraction of the incomplete beta function by Lentz's method; converges fast for x < (a + 1) / (a + b + 2).
double fraction_of_beta(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto nonzero = [](double v) { return std::abs(v) < tiny ? tiny : v; };
  double c = 1, d = 1 / nonzero(1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m < 100'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / nonzero(1 + even * d);
    c = nonzero(1 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / nonzero(1 + odd * d);
    c = nonzero(1 + odd / c);
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-16) break;
  }
  return h;
}

// Probabilities of values below and above x by their logarithms, and the logarithm of x y times the density.
struct LogBeta {
  double below, above, kernel;
};
LogBeta log_beta(const Shapes& shapes, double x, double y) {
  const double a = shapes.a, b = shapes.b, kernel = shapes.log_kernel(x, y);
  const bool lower = x * (a + b + 2) < a + 1;
  const double one = kernel + std::log(lower ? fraction_of_beta(a, b, x) / a : fraction_of_beta(b, a, y) / b);
  const double other = std::log1p(-std::exp(std::min(one, -1e-17)));
  return lower ? LogBeta{one, other, kernel} : LogBeta{other, one, kernel};
}

// A first guess of the logarithm of the quantile.
double log_guess(const Shapes& shapes, double p) {
  const double a = shapes.a, b = shapes.b;
  if (a > 1 && b > 1) {  // Abramowitz and Stegun, 26.5.22
    const double z = -normal_quantile(p), h = 2 / (1 / (2 * a - 1) + 1 / (2 * b - 1)), l = (z * z - 3) / 6;
    if (h + l > 0) {
      const double w = z * std::sqrt(h + l) / h - (1 / (2 * b - 1) - 1 / (2 * a - 1)) * (l + 5.0 / 6 - 2 / (3 * h));
      return -std::log1p(b / a * std::exp(2 * w));
    }
  }
  // p ≈ x^a / (a B(a, b)) for small x
  return (std::log(p * a) - shapes.log_kernel(0.5, 0.5)) / a - (1 + b / a) * std::numbers::ln2;
}

// A quantile below 1/2, by Newton's method for the logarithm of the smaller probability as a function of s = log x.
double lower_quantile(const Shapes& shapes, double p, double q) {
  double low = -std::numeric_limits<double>::infinity(), high = -std::numbers::ln2;
  double s = std::min(log_guess(shapes, p), high);
  for (int i = 0; i < 200 && s > -700; ++i) {
    const double x = std::exp(s), y = -std::expm1(s);
    const LogBeta value = log_beta(shapes, x, y);
    const double smaller = p <= q ? value.below : value.above;
    const double excess = p <= q ? value.below - std::log(p) : std::log(q) - value.above;
    (excess < 0 ? low : high) = s;
    double next = s - excess * y * std::exp(smaller - value.kernel);
    if (!(next >= low && next <= high)) next = std::isinf(low) ? 2 * s - 1 : 0.5 * (low + high);
    const bool done = std::abs(next - s) <= 1e-9;  // the next step would be about the square of this
    s = next;
    if (done) break;
  }
  return s > -700 ? std::exp(s) : 0;
}

}  // namespace

double beta_cdf(double a, double b, double x, double y) {
  if (x <= 0) return 0;
  if (y <= 0) return 1;
  return std::exp(log_beta(Shapes(a, b), x, y).below);
}

BetaPoint beta_quantile(double a, double b, double p) {
  const Shapes shapes(a, b);
  const bool upper = p > std::exp(log_beta(shapes, 0.5, 0.5).below);
  const double small = lower_quantile(Shapes(shapes, upper), upper ? 1 - p : p, upper ? p : 1 - p);
  return upper ? BetaPoint{1 - small, small} : BetaPoint{small, 1 - small};
}

double gamma_variance(double k) {
  if (k > 0.05) {
    const double one = std::tgamma(1 + k);
    return std::tgamma(1 + 2 * k) / (one * one) - 1;
  }
  // log Γ(1 + k) = -γ k + Σ ζ(n) (-k)^n / n, n >= 2
  constexpr std::array<double, 13> zeta{1.6449340668482264, 1.2020569031595943, 1.0823232337111382, 1.0369277551433699,
                                        1.0173430619844491, 1.0083492773819228, 1.0040773561979443, 1.0020083928260822,
                                        1.0009945751278181, 1.0004941886041195, 1.0002460865533080, 1.0001227133475785,
                                        1.0000612481350587};
  double sum = 0, power = -k;
  for (std::size_t i = 0; i < zeta.size(); ++i) {
    const double n = static_cast<double>(i) + 2;
    power *= -k;
    sum += zeta[i] / n * power * (std::exp2(n) - 2);
  }
  return std::expm1(sum);
}

}  // namespace momentree::sweep
