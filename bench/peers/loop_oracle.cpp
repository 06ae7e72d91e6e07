// Accelerations with closed loops by dense matrices: H from inverse dynamics, J by geometry, and the least change of the free
// accelerations in the metric of H, by an orthogonal factorisation that finds the rank. Also the states at which loops are
// closed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "draw.hpp"
#include "loops.hpp"

namespace peers {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A body in motion: world axes, at its origin.
struct Moving {
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero(), v = p, w = p, a = p, alpha = p;
};

/// The degrees of freedom: those of the links (0 for a free one), then the six of a free root. `Oracle::free_dofs` omits the 0.
class Oracle {
 public:
  explicit Oracle(const LoopModel& model) : model_(model), links_(model.links.size()) {
    for (std::size_t i = model.floating() ? 1 : 0; i < links_ + (model.floating() ? 6 : 0); ++i) dofs_.push_back(i);
  }
  std::size_t dofs() const { return dofs_.size(); }

  VectorXd velocities(const LoopState& state) const {
    VectorXd all(static_cast<Eigen::Index>(links_ + 6)), u(static_cast<Eigen::Index>(dofs_.size()));
    for (std::size_t i = 0; i < links_; ++i) all[static_cast<Eigen::Index>(i)] = state.u[i];
    all.tail<6>() << state.root.v, state.root.w;
    for (std::size_t i = 0; i < dofs_.size(); ++i) u[static_cast<Eigen::Index>(i)] = all[static_cast<Eigen::Index>(dofs_[i])];
    return u;
  }
  std::vector<double> by_link(const VectorXd& x) const {
    std::vector<double> all(links_ + (model_.floating() ? 6 : 0));
    for (std::size_t i = 0; i < dofs_.size(); ++i) all[dofs_[i]] = x[static_cast<Eigen::Index>(i)];
    return all;
  }
  void set_velocities(LoopState& state, const VectorXd& u) const {
    const std::vector<double> all = by_link(u);
    std::copy_n(all.begin(), links_, state.u.begin());
    if (!model_.floating()) return;
    const double* const root = all.data() + links_;
    state.root.v = {root[0], root[1], root[2]}, state.root.w = {root[3], root[4], root[5]};
  }

  std::vector<Moving> move(const LoopState& state, const VectorXd& acceleration) const {
    const std::vector<double> rate = by_link(acceleration);
    std::vector<Moving> bodies(links_);
    for (std::size_t i = 0; i < links_; ++i) {
      const Link& link = model_.links[i];
      Moving& b = bodies[i];
      if (link.free) {
        const double* const x = rate.data() + links_;
        b = {state.root.R, state.root.p, state.root.v, state.root.w, Vector3d(x), Vector3d(x + 3)};
        continue;
      }
      const Moving outer = link.parent < 0 ? Moving() : bodies[static_cast<std::size_t>(link.parent)];
      const Vector3d arm = outer.R * link.at;
      b.R = outer.R * link.turn * Eigen::AngleAxisd(state.q[i], Vector3d::UnitZ()).toRotationMatrix();
      const Vector3d axis = b.R.col(2);
      b.p = outer.p + arm;
      b.v = outer.v + outer.w.cross(arm);
      b.w = outer.w + state.u[i] * axis;
      b.a = outer.a + outer.alpha.cross(arm) + outer.w.cross(outer.w.cross(arm));
      b.alpha = outer.alpha + rate[i] * axis + state.u[i] * outer.w.cross(axis);
    }
    return bodies;
  }

  /// Generalised forces that these accelerations need.
  VectorXd forces(const std::vector<Moving>& bodies, double along_z) const {
    std::vector<Vector3d> f(links_), n(links_);
    for (std::size_t i = 0; i < links_; ++i) {
      const Link& link = model_.links[i];
      const Moving& b = bodies[i];
      const Vector3d c = b.R * link.com;
      const Matrix3d inertia = b.R * inertia_of(link) * b.R.transpose();
      f[i] = link.mass * (b.a + b.alpha.cross(c) + b.w.cross(b.w.cross(c)) - Vector3d(0, 0, along_z));
      n[i] = inertia * b.alpha + b.w.cross(inertia * b.w) + c.cross(f[i]);
    }
    VectorXd all = VectorXd::Zero(static_cast<Eigen::Index>(links_ + 6)), found(static_cast<Eigen::Index>(dofs_.size()));
    for (std::size_t i = links_; i-- > 0;) {
      const Link& link = model_.links[i];
      if (link.free) {
        all.tail<6>() << f[i], n[i];
        continue;
      }
      all[static_cast<Eigen::Index>(i)] = bodies[i].R.col(2).dot(n[i]);
      if (link.parent < 0) continue;
      const auto outer = static_cast<std::size_t>(link.parent);
      f[outer] += f[i];
      n[outer] += n[i] + (bodies[i].p - bodies[outer].p).cross(f[i]);
    }
    for (std::size_t i = 0; i < dofs_.size(); ++i) found[static_cast<Eigen::Index>(i)] = all[static_cast<Eigen::Index>(dofs_[i])];
    return found;
  }

  Eigen::Index rows() const { return static_cast<Eigen::Index>(model_.loops.size()) * (model_.planar ? 3 : 6); }
  /// Calls row(first row of a loop, what `of` gives for the body's end less that of the other one), for points and for
  /// directions.
  template <class Point, class Turn>
  VectorXd relative(const std::vector<Moving>& bodies, const Point& point, const Turn& turn) const {
    VectorXd x(rows());
    Eigen::Index row = 0;
    for (const LoopJoint& loop : model_.loops) {
      const Moving one = bodies[static_cast<std::size_t>(loop.body)];
      const Moving two = loop.to < 0 ? Moving() : bodies[static_cast<std::size_t>(loop.to)];
      x.segment<3>(row) = point(one, Vector3d(one.R * loop.at)) - point(two, Vector3d(two.R * loop.to_at));
      row += 3;
      if (model_.planar) continue;
      x.segment<3>(row) = turn(one, two, Matrix3d(one.R * loop.turn), Matrix3d(two.R * loop.to_turn));
      row += 3;
    }
    return x;
  }
  VectorXd residuals(const LoopState& state) const {
    return relative(
        move(state, zero()), [](const Moving& b, const Vector3d& arm) -> Vector3d { return b.p + arm; },
        [](const Moving&, const Moving&, const Matrix3d& A, const Matrix3d& B) -> Vector3d {
          Vector3d x = Vector3d::Zero();
          for (int k = 0; k < 3; ++k) x += 0.5 * Vector3d(B.col(k)).cross(Vector3d(A.col(k)));
          return x;
        });
  }
  MatrixXd jacobian(const LoopState& state) const {
    MatrixXd J(rows(), zero().size());
    LoopState unit = state;
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      set_velocities(unit, VectorXd::Unit(J.cols(), i));
      J.col(i) = relative(
          move(unit, zero()), [](const Moving& b, const Vector3d& arm) -> Vector3d { return b.v + b.w.cross(arm); },
          [](const Moving& one, const Moving& two, const Matrix3d&, const Matrix3d&) -> Vector3d { return one.w - two.w; });
    }
    return J;
  }
  /// J̇ u
  VectorXd drift(const LoopState& state) const {
    return relative(
        move(state, zero()),
        [](const Moving& b, const Vector3d& arm) -> Vector3d { return b.a + b.alpha.cross(arm) + b.w.cross(b.w.cross(arm)); },
        [](const Moving& one, const Moving& two, const Matrix3d&, const Matrix3d&) -> Vector3d { return one.alpha - two.alpha; });
  }

  VectorXd accelerations(const LoopState& state) const {
    LoopState rest = state;
    set_velocities(rest, zero());
    MatrixXd H(zero().size(), zero().size());
    for (Eigen::Index i = 0; i < H.cols(); ++i) H.col(i) = forces(move(rest, VectorXd::Unit(H.cols(), i)), 0);
    const Eigen::LLT<MatrixXd> factor(0.5 * (H + H.transpose()));
    // With x = Lᵀ u̇: the point of J L⁻ᵀ x = −J̇ u that is nearest to the free x.
    const VectorXd free = -factor.matrixL().solve(forces(move(state, zero()), gravity));
    const MatrixXd J = factor.matrixL().solve(jacobian(state).transpose()).transpose();
    const VectorXd x = free - least(J, J * free + drift(state));
    return factor.matrixU().solve(x);
  }
  static VectorXd least(const MatrixXd& J, const VectorXd& right) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor;
    factor.setThreshold(1e-10);
    factor.compute(J);
    return factor.solve(right);
  }

  /// Newton's method.
  void close(LoopState& state) const {
    for (int k = 0; k < 100; ++k) {
      const VectorXd open = residuals(state);
      if (open.norm() < 1e-15 * std::sqrt(static_cast<double>(open.size()))) return;
      if (k > 20 && open.norm() < 1e-14 * std::sqrt(static_cast<double>(open.size()))) return;
      const std::vector<double> step = by_link(least(jacobian(state), open));
      for (std::size_t i = 0; i < links_; ++i) state.q[i] -= step[i];
      if (!model_.floating()) continue;
      const double* const root = step.data() + links_;
      const Vector3d turn = -Vector3d(root + 3);
      state.root.p -= Vector3d(root);
      if (turn.norm() > 0) state.root.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * state.root.R;
    }
    std::fprintf(stderr, "%s: its loops can't be closed\n", model_.name.c_str());
    std::exit(1);
  }
  /// The nearest velocities with J u = 0, the largest of them 1.
  void keep_closed(LoopState& state) const {
    const MatrixXd J = jacobian(state);
    VectorXd u = velocities(state);
    for (int k = 0; k < 2; ++k) u -= least(J, J * u);
    set_velocities(state, u / u.lpNorm<Eigen::Infinity>());
  }
  VectorXd zero() const { return VectorXd::Zero(static_cast<Eigen::Index>(dofs_.size())); }

 private:
  const LoopModel& model_;
  std::size_t links_;
  std::vector<std::size_t> dofs_;
};

}  // namespace

bool LoopModel::grounded() const {
  return std::all_of(loops.begin(), loops.end(), [](const LoopJoint& loop) { return loop.to < 0; });
}

void complete(LoopModel& model) {
  Draw draw(7);
  const Link& root = model.links.front();
  LoopState& first = model.states[0];
  first.root = {root.turn, root.at, root.linear, root.angular};
  first.u.clear();
  for (std::size_t i = 0; i < model.links.size(); ++i) first.u.push_back(draw.between(-1, 1));
  const Oracle oracle(model);
  if (!model.planar) {
    const std::vector<Moving> bodies = oracle.move(first, oracle.zero());
    for (LoopJoint& loop : model.loops) {
      const Moving one = bodies[static_cast<std::size_t>(loop.body)];
      const Moving two = loop.to < 0 ? Moving() : bodies[static_cast<std::size_t>(loop.to)];
      loop.to_turn = two.R.transpose() * one.R * loop.turn;
      loop.to_at = two.R.transpose() * (one.p + one.R * loop.at - two.p);
    }
  }
  oracle.close(first);
  LoopState& second = model.states[1] = first;
  for (std::size_t i = 0; i < second.q.size(); ++i) second.q[i] += 0.01 * static_cast<double>(i % 7 + 1), second.u[i] += 0.1;
  second.root.p += Vector3d(0.01, -0.02, 0.03);
  oracle.close(second);
  for (int k = 0; k < 2; ++k) {
    oracle.keep_closed(model.states[k]);
    model.expected[k] = oracle.by_link(oracle.accelerations(model.states[k]));
  }
}

}  // namespace peers
