// A joint whose freedoms move no mass has a singular joint-space mass (24): found once, before anything runs.
#include <cmath>
#include <vector>

#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

std::vector<SingularJoint> singular_joints(const Model& model) {
  const Tree tree(model);
  std::vector<SingularJoint> found;
  std::vector<SpatialMass<double>> mass(static_cast<std::size_t>(tree.bodies()));
  const auto order = tree.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k];
    SpatialMass<double>& M = mass[static_cast<std::size_t>(b)];
    add_rigid_mass(M, tree.link(b).body);
    const double scale_m = M.A.xx + M.A.yy + M.A.zz, scale_J = M.J.xx + M.J.yy + M.J.zz;
    dispatch(tree.joint(b).kind, [&](auto tag) {
      using K = typename decltype(tag)::type::Kernels;
      const BodySpec& spec = model.bodies()[static_cast<std::size_t>(b)];
      double c[2] = {1, 1}, s[2] = {0, 0};
      for (std::size_t i = 0; i < K::angles.size(); ++i) {
        const double angle = spec.q[K::angles[i]] + (K::turns_about_z ? tree.link(b).angle_0 : 0.0);
        c[i] = std::cos(angle), s[i] = std::sin(angle);
      }
      const double* q = spec.q.begin();
      const JointState<double> joint{q, c, s};
      const auto E = K::template columns<double>(tree.link(b), joint);
      // Judged one freedom after the other, each against the mass that it could move at all.
      for (std::size_t i = 0; i < E.size(); ++i) {
        const Force<double> e = M * E[i];
        const double armature = tree.armature()[tree.first_p(b) + static_cast<int>(i)];
        const double moved = dot(E[i], e) + armature;
        const double scale = dot(E[i].v, E[i].v) * scale_m + dot(E[i].w, E[i].w) * scale_J;
        if (!(moved > 1e-14 * scale) || !(moved > 0)) {
          found.push_back({{b},
                           "the joint-space mass is singular: freedom " + std::to_string(i + 1) + " of " +
                               std::to_string(E.size()) + " of this " + std::string(decltype(tag)::type::info.name) +
                               " joint moves no mass",
                           "give the bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"});
          break;
        }
        if (armature == 0) subtract_outer(M, (1 / moved) * e, e);
      }
      // An armature keeps the freedom's mass; that no more than this is reduced makes the judgement of others milder, never
      // wrong.
      dense_crossing<K, double>(tree.link(b), joint).inboard(M);
    });
    if (tree.parent(b) >= 0) mass[static_cast<std::size_t>(tree.parent(b))] += M;
  }
  return found;
}

}  // namespace momentree
