// A separate file because Eigen takes long to compile.
#include <limits>

#include <Eigen/Eigenvalues>

#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

double Spectrum::condition() const { return smallest > 0 ? largest / smallest : std::numeric_limits<double>::infinity(); }

Spectrum spectrum(const MassMatrix& mass) {
  const int n = mass.size();
  if (n == 0) return {1, 1};
  Eigen::MatrixXd m(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) m(i, j) = static_cast<double>(mass(i, j));
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[0], values[n - 1]};
}

}  // namespace momentree::oracle
