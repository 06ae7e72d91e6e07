#pragma once
// Where the loops' frames are, and what their rows are there, for any scalar. Included only by loop_kernels.cpp and by
// instantiate/*.cpp of other scalars.
#include <momentree/dynamics/loops/loop_system.ipp>
#include <momentree/joint/kernels.hpp>

namespace momentree::detail {

// The joint frame on one side: axes and origin in the world, velocity of the point at x and angular velocity there.
template <class T>
struct LoopSide {
  Matrix3<T> R;
  Vector3<T> x, v{}, w{};
};
template <class T>
MOMENTREE_INLINE LoopSide<T> side_of(const Kinematics<T>* body, const KernelFrame& frame, bool moving) {
  LoopSide<T> side;
  if (body == nullptr) {
    const Mat3& R = frame.R;
    side.R = {T(R.xx), T(R.xy), T(R.xz), T(R.yx), T(R.yy), T(R.yz), T(R.zx), T(R.zy), T(R.zz)};
    side.x = {T(frame.r.x), T(frame.r.y), T(frame.r.z)};
    return side;
  }
  const Kinematics<T>& k = *body;
  const Vector3<T> arm = k.R * frame.r;
  side.R = k.R * frame.R;
  side.x = k.r + arm;
  if (moving) {
    side.w = k.R * k.velocity.w;
    side.v = k.R * k.velocity.v + cross(side.w, side.x - k.r);
  }
  return side;
}

// Writes φ, F, T and Ṫ of the wanted rows of a closure (a bit each), in the parent-side frame: φ̇ = F·v + T·ω for the relative
// velocities there. `angle`: of a screw, from its sine and cosine.
template <class S, class Angle, class Put>
MOMENTREE_INLINE void closure_rows(const Closure& c, unsigned wanted, const Matrix3<S>& R, const Vector3<S>& r,
                                   const Vector3<S>& w, const Angle& angle, const Put& put) {
  const auto constant = [](const Vec3& a) MOMENTREE_INLINE_LAMBDA { return Vector3<S>{S(a.x), S(a.y), S(a.z)}; };
  const Vector3<S> zero{S(0), S(0), S(0)};
  for (int i = 0; i < c.positions; ++i)
    if ((wanted >> i & 1u) != 0) put(i, dot(r, c.position[at(i)]), constant(c.position[at(i)]), zero, zero);
  for (int i = 0; i < c.directions; ++i) {
    if ((wanted >> (c.positions + i) & 1u) == 0) continue;
    const Closure::Direction& d = c.direction[at(i)];
    const Vector3<S> b = R * d.b;
    put(c.positions + i, dot(b, d.a) - d.c, zero, cross(b, d.a), cross(cross(w, b), d.a));
  }
  if (c.screws == 0 || (wanted >> (c.positions + c.directions) & 1u) == 0) return;
  const Closure::Screw& s = c.screw;
  const Vector3<S> e1 = R * s.e1, e2 = R * s.e2;
  const S si = dot(e1, s.e2) - dot(e2, s.e1), co = dot(e1, s.e1) + dot(e2, s.e2), square = si * si + co * co;
  const Vector3<S> ts = cross(e1, s.e2) - cross(e2, s.e1), tc = cross(e1, s.e1) + cross(e2, s.e2);
  const Vector3<S> d1 = cross(w, e1), d2 = cross(w, e2);
  const S sd = dot(d1, s.e2) - dot(d2, s.e1), cd = dot(d1, s.e1) + dot(d2, s.e2);
  const Vector3<S> tsd = cross(d1, s.e2) - cross(d2, s.e1), tcd = cross(d1, s.e1) + cross(d2, s.e2);
  const Vector3<S> gradient = (S(1) / square) * (co * ts - si * tc);
  const Vector3<S> rate = (S(1) / square) * (cd * ts + co * tsd - sd * tc - si * tcd - (2.0 * (si * sd + co * cd)) * gradient);
  put(c.positions + c.directions, dot(r, s.n) - s.h * angle(si, co), constant(s.n), -s.h * gradient, -s.h * rate);
}

// A row of a closure at a place, from φ, F, T and Ṫ in the parent-side frame.
template <class S>
struct RowAt {
  Vector3<S> relative, v, turning;

  MOMENTREE_INLINE explicit RowAt(const LoopPlaceOf<S>& p)
      : relative(p.wb - p.wa), v(p.vb - p.va - cross(p.wa, p.xb - p.xa)), turning(cross(relative, p.vb)) {}
  MOMENTREE_INLINE void put(const LoopPlaceOf<S>& p, const S& phi, const Vector3<S>& F, const Vector3<S>& moment,
                            const Vector3<S>& rate, LoopRowOf<S>& to) const {
    to.residual = phi, to.softness = to.jump_to = S(0);
    to.F = p.Ra * F, to.T = p.Ra * moment;
    to.velocity = dot(to.F, v) + dot(to.T, relative);
    to.rate = cross(p.wa, to.T) + p.Ra * rate;
    to.drift = dot(cross(p.wa, to.F), v) + dot(to.F, turning) + dot(to.rate, relative);
  }
};

// Flattened, because calls of small products take 5 % of a stage.
template <class T>
[[gnu::flatten]] void place_closures(const Tree& tree, const T* q, Workspace<T>& workspace, LoopSystem<T>& loops, bool moving,
                                     LoopRows which) noexcept {
  const UncheckedTree all(tree);
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = 0, last = stops.size(); s < last; ++s) {
    const int b = stops[s].body;
    if (s > 0 && stops[s - 1].body == b) continue;
    const int outer = all.parent(b);
    Kinematics<T>& own = workspace.bodies[at(b)];
    const DenseTransform<T> x = dispatch_kernels(all.kind(b), all.variant(b), [&](auto tag) {
      return dense_transform<typename decltype(tag)::type, T>(all.link(b), joint_state(all, q, workspace, b));
    });
    own.R = outer < 0 ? x.R : workspace.bodies[at(outer)].R * x.R;
    own.r = outer < 0 ? x.r : workspace.bodies[at(outer)].r + workspace.bodies[at(outer)].R * x.r;
    if (moving) own.velocity = workspace.motions[at(b)].velocity;
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loops().links[i];
    const auto side = [&](int body, const KernelFrame& frame) MOMENTREE_INLINE_LAMBDA {
      return side_of(body < 0 ? nullptr : &workspace.bodies[at(body)], frame, moving);
    };
    const LoopSide<T> a = side(loop.to, link.parent), b = side(loop.body, link.child);
    LoopPlaceOf<T>& p = loops.places[i];
    p.Ra = a.R, p.xa = a.x, p.xb = b.x;
    p.R = transpose(a.R) * b.R, p.r = transpose_times(a.R, b.x - a.x);
    p.va = a.v, p.wa = a.w, p.vb = b.v, p.wb = b.w;
    const Vector3<T> origin = workspace.bodies[at(loop.body)].r;
    const auto inner_length = [](const Vec3& v) MOMENTREE_INLINE_LAMBDA { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); };
    const double inner = inner_length(link.child.r) + inner_length(link.parent.r);
    for (int l = 0; l < lanes_of<T>; ++l) {
      const auto length = [l](const Vector3<T>& v) MOMENTREE_INLINE_LAMBDA {
        const double x = get_lane(v.x, l), y = get_lane(v.y, l), z = get_lane(v.z, l);
        return std::sqrt(x * x + y * y + z * z);
      };
      const double size = length(a.x) + length(b.x) + length(origin) + inner;
      set_lane(p.size, l, loops.extents[i] > size ? loops.extents[i] : size);  // everything may be at the origin
    }
    const RowAt<T> row(p);
    const Vector3<T> wr = transpose_times(a.R, row.relative);
    unsigned wanted = ~0u;
    if (which == LoopRows::kept) {
      wanted = 0;
      for (int k = loops.kept.first_of[i]; k < loops.kept.first_of[i + 1]; ++k)
        wanted |= 1u << (loops.kept.rows[at(k)] - link.first_row);
    }
    const auto put = [&](int k, const T& phi, const Vector3<T>& F, const Vector3<T>& moment, const Vector3<T>& rate)
                         MOMENTREE_INLINE_LAMBDA { row.put(p, phi, F, moment, rate, loops.rows[at(link.first_row + k)]); };
    const auto angle = [&](const T& si, const T& co) MOMENTREE_INLINE_LAMBDA {
      T all_lanes(0);
      each_lane<T>(loops, [&](int l) MOMENTREE_INLINE_LAMBDA {
        set_lane(all_lanes, l, screw_angle(get_lane(si, l), get_lane(co, l), loops.turns[i * lanes_of<T> + at(l)].first));
      });
      return all_lanes;
    };
    closure_rows(link.closure, wanted, p.R, p.r, wr, angle, put);
  }
}

template <class T>
void place_other_rows(const Tree& tree, const T* q, const Workspace<T>& workspace, LoopSystem<T>& loops, bool moving) noexcept {
  const std::size_t first = tree.loops().size();
  for (std::size_t i = 0; i < first; ++i) {
    const LoopLink& link = tree.loops().links[i];
    for (int k = 0; k < link.dof_row_count; ++k) {
      LoopRowOf<T>& row = loops.rows[at(link.first_row + link.closure.rows() + k)];
      each_lane<T>(loops, [&](int l) MOMENTREE_INLINE_LAMBDA {
        const std::size_t entry = i * lanes_of<T> + at(l);
        set_lane_of(row, l,
                    dof_row(tree, static_cast<int>(i), link.dof_rows[at(k)], lane_of(loops.places[i], l), loops.turns[entry],
                            loops.motions[entry]));
      });
    }
  }
  const UncheckedTree all(tree);
  for (std::size_t i = first; i < tree.loops().links.size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    const CouplingEnds& ends = link.ends;
    const bool leads = ends.follows >= 0, length = is_length(tree, ends.joint);
    LoopRowOf<T>& row = loops.rows[at(link.first_row)];
    row.F = row.T = {};
    each_lane<T>(loops, [&](int l) MOMENTREE_INLINE_LAMBDA {
      const double x = leads ? get_lane(q[all.first_q(ends.follows)], l) : 0, own = get_lane(q[all.first_q(ends.joint)], l);
      const CouplingPoint f = coupling_point(tree, ends.coupling, x);
      set_lane(row.residual, l, own - f.value);
      set_lane(row.slope, l, f.slope);
      const double rate = moving && leads ? get_lane(workspace.v[at(all.first_p(ends.follows))], l) : 0;
      set_lane(row.velocity, l, moving ? get_lane(workspace.v[at(all.first_p(ends.joint))], l) - f.slope * rate : 0);
      set_lane(row.drift, l, -f.curvature * rate * rate);
      double far = 1;
      if (length) {
        far = 0;
        for (const int body : {ends.joint, ends.follows}) {
          if (body < 0) continue;
          const Vector3<T>& r = workspace.bodies[at(body)].r;
          const double rx = get_lane(r.x, l), ry = get_lane(r.y, l), rz = get_lane(r.z, l);
          far += std::sqrt(rx * rx + ry * ry + rz * rz);
        }
      }
      set_lane(loops.sizes[i - first], l, std::fabs(own) + f.size + far);
    });
  }
}

template <class T>
void add_loop_forces(const Tree& tree, const double* t, Workspace<T>& workspace, LoopSystem<T>& loops, Power* power,
                     const double* given) noexcept {
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    if (!loop.forced()) continue;
    Force<T> all;
    each_lane<T>(loops, [&](int l) MOMENTREE_INLINE_LAMBDA {
      set_lane_of(all, l,
                  loop_force(tree, t[l], static_cast<int>(i), lane_of(loops.places[i], l), loops.turns[i * lanes_of<T> + at(l)],
                             given != nullptr ? given + 6 * i : nullptr, power[l]));
    });
    const auto on = [&](int body)
                        MOMENTREE_INLINE_LAMBDA { return on_body(workspace.bodies[at(body)], all.l, all.h, loops.places[i].xb); };
    Force<T>& child = workspace.biases[at(loop.body)].wrench;
    child = child - on(loop.body);
    if (loop.to >= 0) workspace.biases[at(loop.to)].wrench += on(loop.to);
  }
}

}  // namespace momentree::detail
