#include <momentree/simulate/analysis/inverse_kinematics.hpp>

#include <algorithm>
#include <cmath>
#include <random>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/simulate/analysis/configuration.hpp>

namespace momentree {

namespace {

using analysis::Configuration;

using analysis::at;

bool finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

void check(const World& world, std::span<const KinematicTarget> targets) {
  if (targets.empty()) throw_error({"inverse kinematics needs a target", "", "name a body and where it is to be"});
  for (const KinematicTarget& target : targets) {
    if (target.body == ground || !world.alive(target.body))
      throw_error({"a target of inverse kinematics is a body that can move", "", "the ground and removed bodies are none"});
    const std::string name = "target '" + world.model().bodies()[at(target.body.index)].name + "'";
    if (!target.position && !target.orientation)
      throw_error({name + " has no position and no orientation", "", "give one of them, or both"});
    if (!(target.weight > 0) || !std::isfinite(target.weight)) throw_error({name + ": the weight must be positive", "", ""});
    if (!finite(target.point) || (target.position && !finite(*target.position)))
      throw_error({name + ": its numbers must be finite", "", ""});
    if (target.orientation) {
      const Quat& q = *target.orientation;
      if (!(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-6))
        throw_error({name + ": its orientation must be a unit quaternion", "", "divide it by its length"});
    }
  }
}

struct Errors {
  std::vector<double> rows;  ///< weighted
  double square = 0, position = 0, angle = 0;
};

class Solver {
 public:
  Solver(const World& world, std::span<const KinematicTarget> targets, const KinematicsOptions& options)
      : at_(world),
        targets_(targets),
        options_(options),
        random_(options.seed),
        start_(at_.q().begin(), at_.q().end()),
        turns_(at(at_.nv())) {
    for (const KinematicTarget& target : targets) rows_ += (target.position ? 3 : 0) + (target.orientation ? 3 : 0);
    for (const int b : at_.tree().order())
      for (int i = 0; i < info(at_.tree().kind(b)).nv; ++i)
        turns_[at(at_.tree().first_p(b) + i)] = info(at_.tree().kind(b)).v_units[i] == 'r';
  }

  KinematicSolution solve() {
    KinematicSolution best;
    double least = HUGE_VAL;
    const int attempts = at_.tree().has_loops() ? 1 : std::max(1, options_.attempts);
    int iterations = 0, attempt = 0;
    while (attempt < attempts && !best.reached) {
      if (attempt > 0 && !at_.set(elsewhere())) break;
      ++attempt;
      iterations += descend();
      const Errors left = errors();
      if (!(left.square < least) && !std::isinf(least)) continue;
      least = left.square;
      best.q.assign(at_.q().begin(), at_.q().end());
      best.position_error = left.position, best.angle_error = left.angle;
      best.reached = reached(left);
    }
    best.iterations = iterations, best.attempts = attempt;
    return best;
  }

 private:
  bool reached(const Errors& left) const { return std::max(left.position, left.angle) <= options_.tolerance; }

  // Levenberg's damping, larger after a step that does not help.
  int descend() {
    double damping = 1e-3;
    Errors now = errors();
    int k = 0;
    for (; k < options_.iterations && !reached(now) && damping < 1e12; ++k) {
      const DenseMatrix J = jacobian();
      const std::vector<double> q(at_.q().begin(), at_.q().end());
      const bool moved = at_.displace(move(J, now.rows, damping * std::min(1.0, now.square)));
      const Errors then = errors();
      if (moved && then.square < now.square) {
        now = then, damping = std::max(damping * 0.2, 1e-12);
      } else {
        if (!at_.set(q)) break;
        damping *= 10;
      }
    }
    return k;
  }

  // The least |J y − e|² + damping |y|², without the DoFs that would leave their limits.
  std::vector<double> move(const DenseMatrix& J, const std::vector<double>& e, double damping) {
    std::vector<bool> still(at(at_.nv()));
    std::vector<double> step;
    for (bool again = true; again;) {
      again = false;
      DenseMatrix all(rows_ + at_.nv(), at_.nv());
      std::vector<double> right(at(all.rows));
      for (int i = 0; i < rows_; ++i) {
        right[at(i)] = e[at(i)];
        for (int j = 0; j < at_.nv(); ++j) all(i, j) = still[at(j)] ? 0 : J(i, j);
      }
      for (int j = 0; j < at_.nv(); ++j) all(rows_ + j, j) = std::sqrt(damping + 1e-16);
      step = projection_ * least_squares(all, right);
      double most = 0;  // of the rotations, along which the Jacobian changes
      for (int i = 0; i < at_.nv(); ++i)
        if (turns_[at(i)]) most = std::max(most, std::fabs(step[at(i)]));
      for (double& each : step) each *= most > 0.5 ? 0.5 / most : 1;
      analysis::each_coordinate(at_.tree(), [&](int b, int dof, int p, int q) {
        const analysis::Bounds bounds = analysis::bounds_of(at_.tree(), b, dof);
        const double x = at_.q()[at(q)], to = x + step[at(p)];
        if (still[at(p)]) {
          step[at(p)] = 0;
        } else if ((to > bounds.upper && to > x) || (to < bounds.lower && to < x)) {
          const double edge = to > x ? std::max(bounds.upper, x) : std::min(bounds.lower, x);
          if (x == edge)
            still[at(p)] = again = true;  // it rests on its limit: the others have to do it
          else
            step[at(p)] = edge - x;
        }
      });
    }
    return step;
  }

  Errors errors() {
    locate_bodies(at_.tree(), at_.state(), at_.workspace());
    Errors all;
    const auto add = [&](const Vec3& e, double weight, double& most) {
      for (const double x : {e.x, e.y, e.z}) all.rows.push_back(weight * x), all.square += weight * weight * x * x;
      most = std::max(most, norm(e));
    };
    for (const KinematicTarget& target : targets_) {
      const Pose pose = user_pose(at_.tree(), at_.workspace().bodies[at(target.body.index)], target.body.index);
      if (target.position) add(*target.position - pose * target.point, target.weight, all.position);
      if (target.orientation) add(log_rotation(*target.orientation * conjugate(pose.rotation)), target.weight, all.angle);
    }
    return all;
  }

  // Of the errors' rows, along displacements that are allowed.
  DenseMatrix jacobian() {
    projection_ = at_.projection();
    DenseMatrix J(rows_, at_.nv());
    std::vector<double> six(6 * at(at_.nv()));
    int row = 0;
    for (const KinematicTarget& target : targets_) {
      point_jacobian(at_.tree(), at_.state(), at_.workspace(), target.body, target.point, six.data());
      const auto add = [&](int from) {
        for (int i = from; i < from + 3; ++i, ++row)
          for (int j = 0; j < at_.nv(); ++j) J(row, j) = target.weight * six[at(i) * at(at_.nv()) + at(j)];
      };
      if (target.position) add(0);
      if (target.orientation) add(3);
    }
    return J * projection_;
  }

  // Random coordinates within the limits; without limits, angles of up to a half turn from the start, and lengths of up to 1 m.
  std::vector<double> elsewhere() {
    std::vector<double> q = start_;
    const std::vector<bool> held = at_.held();
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
    };
    analysis::each_coordinate(at_.tree(), [&](int b, int dof, int p, int i) {
      if (held[at(p)]) return;
      const analysis::Bounds bounds = analysis::bounds_of(at_.tree(), b, dof);
      const double far = info(at_.tree().kind(b)).v_units[dof] == 'm' ? 1 : std::acos(-1.0), x = start_[at(i)];
      const double low = std::isfinite(bounds.lower) ? bounds.lower : std::min(x - far, bounds.upper);
      q[at(i)] = uniform(low, std::isfinite(bounds.upper) ? bounds.upper : std::max(x + far, low));
    });
    return q;
  }

  Configuration at_;
  std::span<const KinematicTarget> targets_;
  KinematicsOptions options_;
  std::mt19937_64 random_;
  std::vector<double> start_;
  std::vector<bool> turns_;  // by DoF
  DenseMatrix projection_;
  int rows_ = 0;
};

}  // namespace

KinematicSolution inverse_kinematics(const World& world, std::span<const KinematicTarget> targets,
                                     const KinematicsOptions& options) {
  check(world, targets);
  if (!(options.tolerance > 0) || options.iterations < 1 || options.attempts < 1)
    throw_error({"the options of inverse kinematics must be positive", "", ""});
  return Solver(world, targets, options).solve();
}

}  // namespace momentree
