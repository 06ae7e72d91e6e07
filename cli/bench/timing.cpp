#include <cli/bench/timing.hpp>

#include <momentree/dynamics/momentum.hpp>

namespace momentree::cli {

double momentum_error(const Tree& tree, const double* q, const double* p, const Workspace<double>& work) {
  std::vector<double> again(static_cast<std::size_t>(tree.nv()));
  project_momentum(tree, q, work.v.get(), again.data());
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < again.size(); ++i) {
    const double off = std::fabs(again[i] - p[i]);
    error = off <= error ? error : off;  // keeps NaN
    largest = std::max(largest, std::fabs(p[i]));
  }
  return error / largest;
}

std::vector<double> moved(const Tree& tree, std::vector<double> q) {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += 1e-4 * static_cast<double>(i % 7 + 1);
  for (const int b : tree.joints_with().quaternions) {
    double* u = q.data() + tree.first_q(b) + info(tree.joint(b).kind).nq - 4;
    const double n = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3]);
    for (int i = 0; i < 4; ++i) u[i] /= n;
  }
  return q;
}

}  // namespace momentree::cli
