// Reactions of loop joints, and which reactions the loops determine.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/motion.hpp>

namespace momentree {

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

LoopImpulse loop_impulse(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  LoopImpulse found;
  const LoopWorkspace& loops = *workspace.loops;
  if (!loops.impulsive || loops.solved != tree.revision()) return found;
  const LoopLink& link = tree.loops().links[at(place)];
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    found.force += loops.lambda[row] * loops.rows[row].F;
    found.torque += loops.lambda[row] * loops.rows[row].T;
  }
  if (loops.strike.loop == place) found.force += loops.strike.impulse.l, found.torque += loops.strike.impulse.h;
  found.at = loops.places[at(place)].xb;
  const LoopMotion motion = loop_motion(tree, workspace, place);
  found.motion = motion.effort, found.motion_rate = motion.rate;
  return found;
}

CouplingImpulse coupling_impulse(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  const LoopLink& link = tree.loops().links[at(place)];
  const LoopWorkspace& loops = *workspace.loops;
  CouplingImpulse found{link.ends.coupling, 0, 0};
  if (!loops.impulsive || loops.solved != tree.revision()) return found;
  const auto row = at(link.first_row);
  found.joint = loops.lambda[row], found.follows = -loops.rows[row].slope * loops.lambda[row];
  return found;
}

LoopReaction loop_reaction(const Tree& tree, double t, const Workspace<double>& workspace, int place) noexcept {
  const Loop& loop = tree.loops()[at(place)];
  const LoopLink& link = tree.loops().links[at(place)];
  const LoopWorkspace& loops = *workspace.loops;
  const LoopPlace& p = loops.places[at(place)];
  const Kinematics<double>& child = workspace.bodies[at(loop.body)];
  LoopReaction found;
  Vec3 F{}, T{};
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    F += loops.lambda[row] * loops.rows[row].F;
    T += loops.lambda[row] * loops.rows[row].T;
  }
  Force<double> total = on_body(child, F, T, p.xb);
  const Mat3 Rb = loop_child_axes(p, link);
  const auto on_child = [&](const Force<double>& W) { return on_body(child, Rb * W.l, Rb * W.h, p.xb); };
  total += on_child(loop_joint_wrench(tree, t, workspace, place, found.effort));
  double along[6], q[7] = {}, u[6] = {};
  std::copy_n(found.effort, 6, along);
  for (int i = 0; i < link.dof_row_count; ++i)
    if (link.dof_rows[at(i)].use != DofRow::Use::lock)
      along[link.dof_rows[at(i)].dof] += loops.lambda[at(link.first_row + link.closure.rows() + i)];
  loop_coordinates(tree, workspace, place, q, u);
  const Force<double> pure = total - on_child(joint_wrench(spec_of(loop.joint), q, loop.joint.locked, along));
  const LoopMotion motion = loop_motion(tree, workspace, place);
  found.effort[0] += motion.effort + motion.inertial;
  if (loop.joint.locked != 0) {  // the effort that holds it
    Motion<double> E[6];
    const int nv = joint_columns(spec_of(loop.joint), q, E);
    const Vec3 torque = child.R * total.h - cross(p.xb - child.r, child.R * total.l);
    const Force<double> W{transpose_times(Rb, child.R * total.l), transpose_times(Rb, torque)};
    for (int i = 0; i < nv; ++i)
      if ((loop.joint.locked >> i & 1u) != 0) found.effort[i] = dot(E[i], W);
  }
  found.constraint = {pure.l, pure.h};
  found.total = {total.l, total.h};
  return found;
}

double loop_velocities_open(const Tree& tree, const Workspace<double>& workspace) noexcept {
  double worst = 0;
  if (tree.has_loops())
    for (const LoopRow& row : workspace.loops->rows) worst = std::max(worst, std::fabs(row.velocity));
  return worst;
}

namespace {

constexpr double undetermined_above = 1e-7;  // of a component of the wrench that a unit null vector causes in a joint

using WorldWrench = LoopReactions::WorldWrench;

void add(WorldWrench& sum, double x, const WorldWrench& w) { sum.F += x * w.F, sum.T += x * w.T; }
WorldWrench about(const WorldWrench& w, const Vec3& x) { return {w.F, w.T - cross(x, w.F)}; }

// A null vector of one loop loads no joint beyond the common ancestor of its bodies: what round-off leaves there becomes zero.
void drop_round_off(LoopReactions& work, std::size_t d) {
  constexpr double negligible = 1e-14;  // of the largest load that the vector causes
  std::vector<double>& largest = work.c;
  std::fill(largest.begin(), largest.end(), 0.0);
  for (std::size_t k = 0; k < work.by_null.size(); k += d)
    for (std::size_t i = 0; i < d; ++i) largest[i] = std::max(largest[i], std::fabs(work.by_null[k + i]));
  for (std::size_t k = 0; k < work.by_null.size(); k += d)
    for (std::size_t i = 0; i < d; ++i)
      if (std::fabs(work.by_null[k + i]) < negligible * largest[i]) work.by_null[k + i] = 0;
  std::fill(largest.begin(), largest.end(), 0.0);
}

// The components of the reaction of a joint that null vectors change. `axes`: from those of the child to those of the world.
ReactionParts changed_parts(const LoopReactions& work, std::size_t joint, const Mat3& axes, std::size_t d) {
  ReactionParts parts = 0;
  for (std::size_t i = 0; i < d; ++i) {
    const double* const of = work.by_null.data() + 6 * joint * d + i;
    const Vec3 F = transpose_times(axes, Vec3{of[0], of[d], of[2 * d]});
    const Vec3 T = transpose_times(axes, Vec3{of[3 * d], of[4 * d], of[5 * d]});
    const double six[] = {F.x, F.y, F.z, T.x, T.y, T.z};
    for (unsigned part = 0; part < 6; ++part)
      if (std::fabs(six[part]) > undetermined_above) parts |= 1u << part;
  }
  return parts;
}

// G c = c by Cholesky, without the zeros at the beginning of rows, and with zeros for vectors without effect.
void solve_in_place(LoopReactions& work, std::size_t d) {
  std::vector<double>&G = work.G, &c = work.c;
  std::vector<std::size_t>& begin = work.nonzero;
  begin.assign(d, 0);
  for (std::size_t i = 0; i < d; ++i) {
    while (begin[i] < i && G[i * d + begin[i]] == 0) ++begin[i];
    for (std::size_t k = begin[i]; k <= i; ++k) {
      double x = G[i * d + k];
      for (std::size_t j = std::max(begin[i], begin[k]); j < k; ++j) x -= G[i * d + j] * G[k * d + j];
      if (k < i)
        G[i * d + k] = G[k * d + k] > 0 ? x / G[k * d + k] : 0;
      else
        G[i * d + i] = x > 1e-20 ? std::sqrt(x) : 0;
    }
    for (std::size_t j = begin[i]; j < i; ++j) c[i] -= G[i * d + j] * c[j];
    c[i] = G[i * d + i] > 0 ? c[i] / G[i * d + i] : 0;
  }
  for (std::size_t i = d; i-- > 0;) {
    c[i] = G[i * d + i] > 0 ? c[i] / G[i * d + i] : 0;
    for (std::size_t j = begin[i]; j < i; ++j) c[j] -= G[i * d + j] * c[i];
  }
}

// G += x xᵀ, below the diagonal, and c −= x now, without the zeros of x.
void add_squares(LoopReactions& work, const double* x, double now, std::size_t d) {
  std::vector<std::size_t>& some = work.nonzero;
  some.clear();
  for (std::size_t i = 0; i < d; ++i)
    if (x[i] != 0) some.push_back(i);
  for (std::size_t i = 0; i < some.size(); ++i) {
    const double xi = x[some[i]];
    double* const row = work.G.data() + some[i] * d;
    for (std::size_t k = 0; k <= i; ++k) row[some[k]] += xi * x[some[k]];
    work.c[some[i]] -= xi * now;
  }
}

// The wrenches of multipliers λ (by row) on the child of each loop, about the world's origin.
WorldWrench loop_wrench(const Tree& tree, const LoopWorkspace& loops, std::size_t loop, const double* lambda) {
  WorldWrench sum;
  const LoopLink& link = tree.loops().links[loop];
  for (int i = 0; i < link.rows; ++i) {
    const auto row = at(link.first_row + i);
    if (lambda[row] == 0) continue;
    sum.F += lambda[row] * loops.rows[row].F;
    sum.T += lambda[row] * (loops.rows[row].T + cross(loops.places[loop].xb, loops.rows[row].F));
  }
  return sum;
}

// The effort of a coupling as a force or a torque, so that it counts among the reactions.
WorldWrench coupling_load(const Tree& tree, std::size_t link, const double* lambda) {
  const CouplingEnds& ends = tree.loops().links[link].ends;
  const double effort = lambda[tree.loops().links[link].first_row];
  return info(tree.kind(ends.joint)).q_units[0] == 'm' ? WorldWrench{{effort, 0, 0}, {}} : WorldWrench{{}, {effort, 0, 0}};
}

// The whole wrench of a loop joint on its child at a time t (s), about the joint.
WorldWrench loop_load(const Tree& tree, double t, const Workspace<double>& workspace, std::size_t loop) {
  const LoopWorkspace& loops = *workspace.loops;
  const LoopPlace& place = loops.places[loop];
  WorldWrench load = about(loop_wrench(tree, loops, loop, loops.lambda.data()), place.xb);
  double effort[6] = {};
  const Force<double> own = loop_joint_wrench(tree, t, workspace, static_cast<int>(loop), effort);
  const Mat3 R = loop_child_axes(place, tree.loops().links[loop]);
  add(load, 1, {R * own.l, R * own.h});
  return load;
}

// The origin of the child-side frame of a body's inboard joint in the world: there the wrenches of joints are taken, whether they
// close a loop or not.
Vec3 joint_place(const Tree& tree, const Workspace<double>& workspace, int b) {
  const int child = tree.reversed(b) ? tree.parent(b) : b;
  const KernelFrame& frame = tree.frame(child);
  const Kinematics<double>& body = workspace.bodies[at(child)];
  return body.r + body.R * transpose_times(frame.R, tree.joint(b).child_at.position - frame.r);
}

// Of the child of a joint, in the world; of couplings, which have no direction, those of the world.
Mat3 child_axes(const Tree& tree, const Workspace<double>& workspace, const LoopReactions::Carried& joint) {
  int child = joint.body;
  if (child < 0 && at(joint.loop) >= tree.loops().size()) return rotation_matrix(Quat{});
  if (child < 0)
    child = tree.loops()[at(joint.loop)].body;
  else if (tree.reversed(child))
    child = tree.parent(child);
  return rotation_matrix(user_pose(tree, workspace.bodies[at(child)], child).rotation);
}

// The size of the mechanism, by which torques are divided (m): the extent of its joints, whichever of them close loops.
double extent(const Tree& tree, const std::vector<LoopReactions::Carried>& joints) {
  const auto counts = [&](const LoopReactions::Carried& joint) {
    if (joint.body >= 0) return tree.kind(joint.body) != Kind::free;
    return at(joint.loop) < tree.loops().size() && tree.loops()[at(joint.loop)].joint.kind != Kind::free;
  };
  Vec3 centre{};
  int count = 0;
  for (const LoopReactions::Carried& joint : joints)
    if (counts(joint)) centre += joint.at, ++count;
  double size = 0;
  for (const LoopReactions::Carried& joint : joints)
    if (counts(joint)) size = std::max(size, norm(joint.at - (1.0 / count) * centre));
  return size > 1e-9 ? size : 1;
}

// What multipliers add to the wrench of each joint on its child: of the inboard joints of bodies at stops, then of the loops. A
// joint of the tree carries the opposite of what the loops exert on the bodies outboard.
void joint_wrenches(const Tree& tree, const LoopWorkspace& loops, const double* lambda, LoopReactions& into) {
  into.by_body.assign(at(tree.bodies()), {});
  into.by_loop.assign(tree.loops().size(), {});
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    into.by_loop[i] = loop_wrench(tree, loops, i, lambda);
    add(into.by_body[at(tree.loops()[i].body)], -1, into.by_loop[i]);
    if (tree.loops()[i].to >= 0) add(into.by_body[at(tree.loops()[i].to)], 1, into.by_loop[i]);
  }
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = stops.size(); s-- > 0;) {
    if (s > 0 && stops[s - 1].body == stops[s].body) continue;  // once per body
    const int outer = tree.parent(stops[s].body);
    if (outer >= 0) add(into.by_body[at(outer)], 1, into.by_body[at(stops[s].body)]);
  }
}

}  // namespace

// Rows that were not chosen are combinations of the chosen ones: each gives a vector of multipliers that moves nothing, but
// shifts reactions from joint to joint. Of all possible reactions the least ones are reported, in the norm Σ |force|² + |torque /
// size|² over all joints, which depends neither on the tree nor on the chosen rows.
void find_least_reactions(const Tree& tree, double t, Workspace<double>& workspace) {
  LoopWorkspace& loops = *workspace.loops;
  loops.open.bodies.assign(at(tree.bodies()), 0);
  loops.open.links.assign(tree.loops().links.size(), 0);
  loops.least = true;
  const std::size_t m = loops.rows.size(), d = m - loops.kept.rows.size();
  if (d == 0) return;
  LoopReactions& work = loops.reactions;
  work.lambda = loops.lambda;
  work.null.clear();
  for (std::size_t row = 0; row < m; ++row) {
    if (std::binary_search(loops.kept.rows.begin(), loops.kept.rows.end(), static_cast<int>(row))) continue;
    detail::solve_chosen(loops, [&](std::size_t i) { return -loops.all.element(loops.A, i, row); });
    loops.lambda[row] = 1;
    work.null.insert(work.null.end(), loops.lambda.begin(), loops.lambda.end());
  }
  loops.lambda = work.lambda;
  work.joints.clear();
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = 0; s < stops.size(); ++s) {
    if (s > 0 && stops[s - 1].body == stops[s].body) continue;
    const Kinematics<double>& body = workspace.bodies[at(stops[s].body)];
    const Force<double> W = transmitted_wrench(tree, workspace, stops[s].body);
    const Vec3 x = joint_place(tree, workspace, stops[s].body), F = body.R * W.l;
    work.joints.push_back({stops[s].body, -1, x, {F, body.R * W.h - cross(x - body.r, F)}});
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    work.joints.push_back({-1, static_cast<int>(i), loops.places[i].xb, loop_load(tree, t, workspace, i)});
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i)
    work.joints.push_back({-1, static_cast<int>(i), {}, coupling_load(tree, i, work.lambda.data())});
  const double size = extent(tree, work.joints);
  // What a unit of each null vector adds to a joint: six numbers, force and torque / size, in a row of d each.
  work.by_null.resize(6 * work.joints.size() * d);
  for (std::size_t i = 0; i < d; ++i) {
    const double* const lambda = work.null.data() + i * m;
    joint_wrenches(tree, loops, lambda, work);
    for (std::size_t k = 0; k < work.joints.size(); ++k) {
      const LoopReactions::Carried& joint = work.joints[k];
      const WorldWrench added =
          joint.body < 0 && at(joint.loop) >= tree.loops().size()
              ? coupling_load(tree, at(joint.loop), lambda)
              : about(joint.body >= 0 ? work.by_body[at(joint.body)] : work.by_loop[at(joint.loop)], joint.at);
      const Vec3 T = (1 / size) * added.T;
      const double six[] = {added.F.x, added.F.y, added.F.z, T.x, T.y, T.z};
      for (std::size_t c = 0; c < 6; ++c) work.by_null[(6 * k + c) * d + i] = six[c];
    }
  }
  work.G.assign(d * d, 0.0), work.c.assign(d, 0.0);
  const std::vector<double>& c = work.c;
  drop_round_off(work, d);
  for (std::size_t joint = 0; joint < work.joints.size(); ++joint) {
    const LoopReactions::Carried& at_joint = work.joints[joint];
    (at_joint.body >= 0 ? loops.open.bodies[at(at_joint.body)] : loops.open.links[at(at_joint.loop)]) =
        static_cast<unsigned char>(changed_parts(work, joint, child_axes(tree, workspace, at_joint), d));
    const Vec3 F = at_joint.now.F, T = (1 / size) * at_joint.now.T;
    const double now[] = {F.x, F.y, F.z, T.x, T.y, T.z};
    for (std::size_t part = 0; part < 6; ++part) add_squares(work, work.by_null.data() + (6 * joint + part) * d, now[part], d);
  }
  solve_in_place(work, d);
  for (std::size_t i = 0; i < d; ++i)
    for (std::size_t row = 0; row < m; ++row) loops.lambda[row] += c[i] * work.null[i * m + row];
  for (std::size_t joint = 0; joint < work.joints.size(); ++joint) {
    const int body = work.joints[joint].body;
    if (body < 0) continue;
    double more[6] = {};
    for (std::size_t part = 0; part < 6; ++part)
      for (std::size_t i = 0; i < d; ++i) more[part] += c[i] * work.by_null[(6 * joint + part) * d + i];
    const Kinematics<double>& own = workspace.bodies[at(body)];
    const Mat3& R = own.R;
    const Vec3 F{more[0], more[1], more[2]};  // back to the origin of the kernel frame
    const Vec3 T = size * Vec3{more[3], more[4], more[5]} + cross(work.joints[joint].at - own.r, F);
    workspace.reduced_bias_wrenches[at(body)] += Force<double>{transpose_times(R, F), transpose_times(R, T)};
  }
}

ReactionParts open_parts_of_link(const Tree& tree, const Workspace<double>& workspace, int place) noexcept {
  MT_REQUIRE(!tree.has_loops() || workspace.loops->least, "accelerate was called for this state");
  return workspace.loops->open.links[at(place)];
}

ReactionParts open_parts_of_joint(const Tree& tree, const Workspace<double>& workspace, int body) noexcept {
  MT_REQUIRE(!tree.has_loops() || workspace.loops->least, "accelerate was called for this state");
  return workspace.loops->open.bodies[at(body)];
}

}  // namespace momentree
