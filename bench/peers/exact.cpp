// The exact solution: bodies in maximal coordinates, joints as constraints, one dense projection.
#include <cmath>
#include <utility>

#include <Eigen/Dense>

#include "experiment.hpp"

namespace peers {

std::vector<Motion> exact(const Experiment& experiment) {
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const std::vector<Link>& links = experiment.links;
  std::vector<Motion> motions = start(experiment);
  const int n = static_cast<int>(links.size());
  // Six velocities per body: of the centre of mass, and angular; scaled by roots of the mass matrix, so that the projection is
  // orthogonal.
  VectorXd u(6 * n);
  std::vector<Matrix3d> root(n), root_inverse(n);
  for (int i = 0; i < n; ++i) {
    const Matrix3d& R = motions[i].R;
    root[i] = R * links[i].inertia.cwiseSqrt().asDiagonal() * R.transpose();
    root_inverse[i] = R * links[i].inertia.cwiseSqrt().cwiseInverse().asDiagonal() * R.transpose();
    u.segment<3>(6 * i) = std::sqrt(links[i].mass) * centre_velocity(links[i], motions[i]);
    u.segment<3>(6 * i + 3) = root[i] * motions[i].w;
  }
  MatrixXd rows = MatrixXd::Zero(6 * n + 6, 6 * n);  // of the constraints
  int m = 0;
  const auto put = [&](int row, int body, const Vector3d& linear, const Vector3d& angular, double sign) {
    rows.block<1, 3>(row, 6 * body) += sign / std::sqrt(links[body].mass) * linear.transpose();
    rows.block<1, 3>(row, 6 * body + 3) += sign * (root_inverse[body] * angular).transpose();
  };
  // No relative velocity at a point; no rotation about the given axes.
  const auto hold = [&](int a, int b, const Vector3d& point, const Matrix3d& axes, int turns) {
    for (int k = 0; k < 3 + turns; ++k, ++m) {
      for (const auto& [body, sign] : {std::pair{a, 1.0}, std::pair{b, -1.0}}) {
        if (body < 0) continue;
        const Vector3d arm = point - centre(links[body], motions[body]);
        if (k < 3) put(m, body, Vector3d::Unit(k), arm.cross(Vector3d::Unit(k)), sign);
        if (k >= 3) put(m, body, Vector3d::Zero(), axes.col(k - 3), sign);
      }
    }
  };
  for (int i = 0; i < n; ++i) {
    if (links[i].free || (experiment.change == Change::cut && i == experiment.body)) continue;
    const bool locked = experiment.change == Change::lock && i == experiment.body;
    hold(i, links[i].parent, motions[i].p, motions[i].R, locked ? 3 : 2);
  }
  if (experiment.change == Change::capture) hold(experiment.body, experiment.to, motions[experiment.body].p, motions[0].R, 3);
  if (m > 0) {
    const Eigen::ColPivHouseholderQR<MatrixXd> across(rows.topRows(m).transpose());
    const MatrixXd basis = across.householderQ() * MatrixXd::Identity(6 * n, across.rank());
    for (int pass = 0; pass < 2; ++pass) u -= basis * (basis.transpose() * u);
  }
  for (int i = 0; i < n; ++i) {
    motions[i].w = root_inverse[i] * u.segment<3>(6 * i + 3);
    motions[i].v = u.segment<3>(6 * i) / std::sqrt(links[i].mass) - motions[i].w.cross(motions[i].R * links[i].com);
  }
  return motions;
}

}  // namespace peers
