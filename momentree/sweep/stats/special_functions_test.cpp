#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/sweep/stats/distribution.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

using namespace momentree::sweep;

// Expected values: mpmath 1.3 with 40 to 60 digits, of the double given here: erfc(-x/√2)/2 and its inverse by Halley's method;
// betainc(a, b, 0, x, regularized=True), for large or tiny shapes quad() of the density.
namespace {

struct Row {
  double in, out;
};
double relative(double value, double expected) { return std::abs(value / expected - 1); }

}  // namespace

TEST_CASE("quantiles of the normal distribution to 1e-15") {
  for (const Row& row : std::vector<Row>{{1e-300, -37.0470962993612},
                                         {1e-100, -21.273453560965326},
                                         {1e-16, -8.222082216130435},
                                         {1e-12, -7.034483825301132},
                                         {1e-05, -4.264890793922825},
                                         {0.001, -3.0902323061678136},
                                         {0.0249, -1.961677869063786},
                                         {0.0751, -1.43882539275254},
                                         {0.1, -1.2815515655446004},
                                         {0.25, -0.6744897501960817},
                                         {0.4, -0.2533471031357997},
                                         {0.499999, -2.5066282745665593e-06},
                                         {0.5000001, 2.506628273311648e-07},
                                         {0.7, 0.5244005127080407},
                                         {0.925, 1.4395314709384561},
                                         {0.9251, 1.440238267527964},
                                         {0.99, 2.3263478740408408},
                                         {0.999999, 4.753424308817087},
                                         {0.9999999999999999, 8.209536151601387}}) {
    CAPTURE(row.in);
    CHECK(relative(normal_quantile(row.in), row.out) < 1e-15);
  }
  CHECK(normal_quantile(0.5) == 0);
}

TEST_CASE("probabilities of the normal distribution to 1e-14, relative to the tail") {
  for (const Row& row : std::vector<Row>{{-37.5, 4.605353009581955e-308},
                                         {-30, 4.906713927148187e-198},
                                         {-20.3, 6.429244467698346e-92},
                                         {-10.1, 2.762109471764517e-24},
                                         {-5, 2.866515718791939e-07},
                                         {-2.2, 0.013903447513498604},
                                         {-1, 0.15865525393145705},
                                         {-0.1, 0.460172162722971},
                                         {-1e-10, 0.49999999996010575},
                                         {0.3, 0.6179114221889527},
                                         {1, 0.8413447460685429},
                                         {2, 0.9772498680518208},
                                         {5, 0.9999997133484281},
                                         {8, 0.9999999999999993}}) {
    CAPTURE(row.in);
    CHECK(relative(normal_cdf(row.in), row.out) < 1e-14);
  }
  const double infinite = std::numeric_limits<double>::infinity();
  CHECK(normal_cdf(-infinite) == 0);
  CHECK(normal_cdf(infinite) == 1);
}

TEST_CASE("probabilities and quantiles of the beta distribution") {
  struct Beta4 {
    double a, b, x, p;
  };
  for (const Beta4& row : std::vector<Beta4>{{2, 3, 0.1, 0.052300000000000006},
                                             {2, 3, 0.5, 0.6875},
                                             {2, 3, 0.95, 0.99951875},
                                             {0.5, 0.5, 1e-10, 6.366197723781917e-06},
                                             {0.5, 0.5, 0.3, 0.36901011956554536},
                                             {0.5, 0.5, 0.9, 0.7951672353008665},
                                             {0.1, 7.5, 1e-05, 0.4041211593049313},
                                             {0.1, 7.5, 0.2, 0.9898263201784434},
                                             {1, 1, 0.37, 0.37},
                                             {1, 5, 0.01, 0.0490099501},
                                             {30, 2, 0.8, 0.008665580274997675},
                                             {30, 2, 0.99, 0.9616104854047645},
                                             {100.5, 200.25, 0.3, 0.10290345411588173},
                                             {100.5, 200.25, 0.36, 0.8292740084113805},
                                             {1000, 1000, 0.49, 0.18555265943151145},
                                             {1000, 1000, 0.55, 0.999996316801131},
                                             {1e5, 3e5, 0.2505, 0.7674823538033121},
                                             {1e6, 1e6, 0.5005, 0.9213504224190753},
                                             {1e6, 1e6, 0.499, 0.0023388494069315046},
                                             {0.001, 0.001, 0.25, 0.499451507519294},
                                             {0.001, 1000, 1e-06, 0.9936871512713972},
                                             {1e6, 0.5, 0.9999995, 0.3173105078828051}}) {
    CAPTURE(row.a);
    CAPTURE(row.b);
    CAPTURE(row.x);
    const double y = 1 - row.x, tolerance = row.a + row.b > 1e5 ? 2e-11 : 1e-13;
    CHECK(relative(beta_cdf(row.a, row.b, row.x, y), row.p) < tolerance);
    CHECK(relative(beta_cdf(row.b, row.a, y, row.x), 1 - row.p) < tolerance / (1 - row.p));
    // Rounding of p alone moves x by dp / density.
    const double step = 1e-6 * std::min(row.x, y);
    const double slope =
        (beta_cdf(row.a, row.b, row.x + step, y - step) - beta_cdf(row.a, row.b, row.x - step, y + step)) / (2 * step);
    CHECK(std::abs(beta_quantile(row.a, row.b, row.p).x - row.x) < 1e-13 * row.x + tolerance / slope);
  }
  // SciPy 1.17: scipy.special.betaincinv(a, b, p)
  struct Inverse {
    double a, b, p, x;
  };
  for (const Inverse& row : std::vector<Inverse>{{0.01, 5, 0.9, 3.3308179949666207e-06},
                                                 {0.01, 5, 0.5, 9.892240424112215e-32},
                                                 {5, 0.01, 0.1, 0.999996669182005},
                                                 {0.2, 0.3, 0.4, 0.08683942933345191},
                                                 {2, 3, 1e-10, 4.082494015808333e-06},
                                                 {1e5, 3e5, 0.5, 0.24999958333299893},
                                                 {0.5, 0.5, 0.999999, 0.9999999999975326},
                                                 {30, 0.7, 0.2, 0.9621874354400073},
                                                 {1e6, 1e6, 1e-06, 0.4983194152552276}}) {
    CAPTURE(row.a);
    CAPTURE(row.p);
    const BetaPoint found = beta_quantile(row.a, row.b, row.p);
    CHECK(relative(found.x, row.x) < 1e-12);
    CHECK(found.x + found.y == 1);
  }
}

TEST_CASE("moments and quantiles of truncated normal distributions") {
  const double infinite = std::numeric_limits<double>::infinity();
  struct Truncated {
    Normal normal;
    double u, quantile, mean, deviation;
  };
  // mpmath: the closed forms with 60 digits
  for (const Truncated& row :
       std::vector<Truncated>{{{1, 0.5, Interval{0.5, 2}}, 0.3, 0.8787980910553865, 1.1148185895456644, 0.3604727934295229},
                              {{0, 1, Interval{6, infinite}}, 0.25, 6.046541477816288, 6.158482604544599, 0.15487942661685822},
                              {{0, 1, Interval{6, infinite}}, 0.999, 7.036366493709703, 6.158482604544599, 0.15487942661685822},
                              {{10, 2, Interval{-infinite, 5}}, 0.9, 4.925793455037756, 4.354510404672186, 0.5965695313075097},
                              {{0, 1, Interval{1, 1.001}}, 0.5, 1.000499874937513, 1.0004999166250041, 0.00028867512255943256},
                              {{3, 1, Interval{-20, 3.5}}, 0.99, 3.4804543910516124, 2.4908395661629665, 0.6972628168032245}}) {
    const Distribution distribution(row.normal);
    CAPTURE(distribution.text());
    CHECK(relative(distribution.quantile(row.u), row.quantile) < 1e-14);
    CHECK(relative(distribution.mean(), row.mean) < 1e-13);
    CHECK(relative(distribution.deviation(), row.deviation) < 1e-12);
  }
}

TEST_CASE("moments of Weibull distributions") {
  struct Moments3 {
    double shape, mean, deviation;
  };
  // mpmath: 2 Γ(1 + 1/k), 2 √(Γ(1 + 2/k) - Γ(1 + 1/k)²)
  for (const Moments3& row : std::vector<Moments3>{{0.05, 4.865804016353264e+18, 1.8065605810400847e+24},
                                                   {0.5, 4, 8.94427190999916},
                                                   {1, 2, 2},
                                                   {3.6, 1.802211366564579, 0.5560405740899534},
                                                   {19.9, 1.9467650956730747, 0.12124019768041797},
                                                   {20.1, 1.9472497598917897, 0.12010195580218863},
                                                   {1000, 1.998847544969191, 0.0025617514957427005}}) {
    const Distribution weibull{Weibull{2, row.shape}};
    CAPTURE(row.shape);
    CHECK(relative(weibull.mean(), row.mean) < 1e-13);
    CHECK(relative(weibull.deviation(), row.deviation) < 1e-12);
  }
}
