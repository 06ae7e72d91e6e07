#pragma once
// The rows of closed loops as dense matrices, from Jacobians of points and from the directions that a joint allows: they share no
// code with the rows of the engine.
#include <algorithm>
#include <string>
#include <vector>

#include <momentree/joint/motion.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/random_model.hpp>

namespace momentree::oracle {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

inline Eigen::Vector3d eigen(const Vec3& a) { return {a.x, a.y, a.z}; }

// Pose of a joint's side: `at` in the frame of a body, or of the ground.
inline Pose side(const World& world, BodyId body, const Pose& at) {
  return body == ground ? at : world.motions()[static_cast<std::size_t>(body.index)].pose * at;
}

// J of one loop joint, with as many rows as it blocks directions: components of the relative velocity of its frames, in world
// axes about the child's, that are orthogonal to the joint's own motions.
inline Matrix rows_of(const World& world, JointId loop) {
  const JointView joint = world.joint(loop);
  const int n = world.tree().nv();
  const Pose child = side(world, joint.child, joint.child_at);
  const auto jacobian = [&](BodyId body) -> Matrix {
    Matrix J = Matrix::Zero(6, n);
    if (body == ground) return J;
    const Pose pose = world.motions()[static_cast<std::size_t>(body.index)].pose;
    world.equations().point_jacobian(body, inverse(pose) * child.position, J.data());
    return J;
  };
  const Matrix relative = jacobian(joint.child) - jacobian(joint.parent);
  JointSpec spec;
  spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
  const std::vector<Motion<double>> dofs = joint_dofs(spec, joint.q.data());
  Matrix allowed(6, static_cast<int>(dofs.size()));
  const Mat3 R = rotation_matrix(child.rotation);
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    allowed.block<3, 1>(0, static_cast<int>(i)) = eigen(R * dofs[i].v);
    allowed.block<3, 1>(3, static_cast<int>(i)) = eigen(R * dofs[i].w);
  }
  Matrix blocked = Matrix::Identity(6, 6);
  if (!dofs.empty()) {
    const Eigen::FullPivLU<Matrix> lu(allowed.transpose());
    blocked = lu.kernel();
  }
  return blocked.transpose() * relative;
}

inline Matrix rows_of(const World& world) {
  Matrix all(0, world.tree().nv());
  for (const JointId loop : world.loops()) {
    const Matrix own = rows_of(world, loop);
    Matrix more(all.rows() + own.rows(), all.cols());
    more << all, own;
    all = more;
  }
  return all;
}

inline Matrix null_space(const Matrix& J) {
  const Eigen::JacobiSVD<Matrix> svd(J, Eigen::ComputeFullV);
  int rank = 0;
  for (int i = 0; i < svd.singularValues().size(); ++i)
    rank += svd.singularValues()(i) > 1e-9 * std::max(1.0, svd.singularValues()(0)) ? 1 : 0;
  return svd.matrixV().rightCols(J.cols() - rank);
}

// True close to a singular configuration, where the engine takes a nearly dependent row for a dependent one.
inline bool nearly_singular(const Matrix& J) {
  const Eigen::JacobiSVD<Matrix> svd(J);
  const auto& s = svd.singularValues();
  return std::any_of(s.begin(), s.end(), [&](double x) { return x > 1e-9 * std::max(1.0, s(0)) && x < 1e-3 * s(0); });
}

inline Vector as_vector(Numbers numbers) { return Eigen::Map<const Vector>(numbers.data(), static_cast<int>(numbers.size())); }

inline Matrix mass_of(const World& world) {
  Matrix M(world.tree().nv(), world.tree().nv());
  world.equations().mass_matrix(M.data());
  return M;
}

/// A random tree of 3 to 9 bodies with one to three loop joints of random kinds.
/// `motion`: the first pin or slide has a prescribed motion.
inline Model with_loops(std::uint64_t seed, RandomTreeOptions options, bool motion = false) {
  options.min_bodies = 3, options.max_bodies = 9;
  const Model open = random_tree(seed, options).model;
  Model model({.gravity = open.gravity()});
  for (BodySpec body : open.bodies()) {
    if (motion && (body.joint.kind == Kind::revolute || body.joint.kind == Kind::prismatic)) {
      body.joint.parameters = {};
      body.joint.parameters.drive = motion_drive(Signal::sine(0.4, 1.5));
      body.q = 0, body.v = 0;
      motion = false;
    }
    model.add(body);
  }
  Prng random(seed + 1000);
  const World world(model);
  const int count = random.integer(1, 3);
  for (int k = 0; k < count; ++k) {
    LoopSpec loop;
    loop.name = "loop" + std::to_string(k);
    loop.body = {random.integer(0, model.size() - 1)}, loop.to = {random.integer(-1, model.size() - 1)};
    if (loop.body == loop.to) continue;
    const std::vector<Kind>& kinds = every_kind();
    do
      loop.joint =
          random_joint(random, kinds[static_cast<std::size_t>(random.integer(0, static_cast<int>(kinds.size()) - 1))], options);
    while (loop.joint.kind == Kind::free);
    loop.joint.parameters.armature = {};
    loop.child_at.position = random.vector(0.5);
    const Vec3 axis = random.direction();
    loop.child_at.rotation = from_axis_angle(axis, random.uniform(-2, 2));
    const Values q = random_coordinates(random, loop.joint.kind);
    loop.at =
        inverse(side(world, loop.to, {})) * side(world, loop.body, loop.child_at) * inverse(joint_motion(loop.joint, q.begin()));
    model.add_loop(loop);
  }
  return model;
}
inline Model with_loops(std::uint64_t seed, bool parameters) {
  RandomTreeOptions options;
  options.parameters = parameters;
  return with_loops(seed, options);
}

}  // namespace momentree::oracle
