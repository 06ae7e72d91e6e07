// A joint whose DoFs move no mass has a singular joint-space mass (24): checked before a simulation runs, and after changes that
// may cause it.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sine_cosine.hpp>
#include <momentree/model/start.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

// An upper bound of the mass that a motion E can move, regardless of the axes' orientation.
double bound(const SpatialMass<double>& M, const Motion<double>& E) {
  return dot(E.v, E.v) * (M.A.xx + M.A.yy + M.A.zz) + dot(E.w, E.w) * (M.J.xx + M.J.yy + M.J.zz);
}

// The mass close to a joint: its own body and, across their joints, its children before their DoFs reduce them. The mass across
// the joints of a long chain is a million times the mass along them, without being singular.
double mass_nearby(const Tree& tree, const std::vector<SpatialMass<double>>& carried, int b, const Motion<double>& E) {
  SpatialMass<double> own{};
  add_rigid_mass(own, tree.link(b).body);
  double sum = bound(own, E);
  for (int c = tree.first_child(b); c >= 0; c = tree.next_sibling(c)) {
    const SpatialMass<double>& M = carried[static_cast<std::size_t>(c)];
    sum += tree.kind(c) == Kind::weld ? bound(M, E) : dot(E, M * E);
  }
  return sum;
}

}  // namespace

std::vector<SingularJoint> singular_joints(const Model& model) {
  const Tree& tree = model.compiled();
  std::vector<double> q(static_cast<std::size_t>(tree.nq()));
  for (const int b : tree.order()) {
    const Values own = start_coordinates(model[BodyId{b}]);
    std::copy(own.begin(), own.end(), q.begin() + tree.first_q(b));
  }
  return singular_joints(tree, q);
}

std::vector<SingularJoint> singular_joints(const Tree& tree, std::span<const double> coordinates) {
  std::vector<SingularJoint> found;
  std::vector<SpatialMass<double>> mass(static_cast<std::size_t>(tree.bodies()));
  std::vector<SpatialMass<double>> carried(mass.size());  // the same in the parent's frame, before the joint's DoFs reduce it
  const auto order = tree.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k];
    SpatialMass<double>& M = mass[static_cast<std::size_t>(b)];
    add_rigid_mass(M, tree.link(b).body);
    const SpatialMass<double> full = M;
    double c[2] = {1, 1}, s[2] = {0, 0};
    for (int i = 0; i < shape(tree.kind(b)).angles; ++i) {
      const auto at = static_cast<std::size_t>(tree.tables().offsets[static_cast<std::size_t>(b)].angle + i);
      const double angle = coordinates[static_cast<std::size_t>(tree.tables().angle_q[at])] + tree.tables().angle_offset[at];
      const SineCosine both = sine_cosine(angle);
      c[i] = both.c, s[i] = both.s;
    }
    const JointState<double> joint{coordinates.data() + tree.first_q(b), c, s};
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      using K = typename decltype(tag)::type;
      const auto E = K::template columns<double>(tree.link(b), joint);
      // Checks one DoF after the other, each against the mass that it could move at most.
      for (std::size_t i = 0; i < E.size(); ++i) {
        if ((tree.link(b).locked >> i & 1u) != 0) continue;  // frozen or driven
        const Force<double> e = M * E[i];
        const double armature = tree.tables().armature[tree.first_p(b) + static_cast<int>(i)];
        const double moved = dot(E[i], e) + armature;
        const bool next_to_nothing = moved <= 1e-14 * bound(full, E[i]) && moved <= 1e-10 * mass_nearby(tree, carried, b, E[i]);
        if (!(moved > 0) || next_to_nothing) {
          found.push_back({{b},
                           "the joint-space mass is singular: degree of freedom " + std::to_string(i + 1) + " of " +
                               std::to_string(E.size()) + " of this " + info(tree.kind(b)).name + " joint moves no mass",
                           "give the bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"});
          break;
        }
        if (armature == 0) subtract_outer(M, (1 / moved) * e, e);
      }
      // An armature keeps the DoF's mass, so the mass is not reduced for it; this makes the check of other joints more lenient,
      // never wrong.
      const auto crossing = dense_transform<K, double>(tree.link(b), joint);
      crossing.inboard(M);
      carried[static_cast<std::size_t>(b)] = full;
      crossing.inboard(carried[static_cast<std::size_t>(b)]);
    });
    if (tree.parent(b) >= 0) mass[static_cast<std::size_t>(tree.parent(b))] += M;
  }
  return found;
}

}  // namespace momentree
