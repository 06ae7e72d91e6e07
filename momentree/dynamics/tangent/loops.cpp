// Closed loops and couplings in derivatives of accelerations.
#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/loops/loop_place.ipp>
#include <momentree/dynamics/tangent/memory.hpp>

namespace momentree {

using namespace detail::tangents;

namespace {

Number angle_of(const Number& si, const Number& co, double turn) {
  const Number angle = atan2(si, co);
  return {detail::screw_angle(si.r, co.r, turn), angle.e};
}

// Where a loop's frames are, with velocities of its bodies.
LoopPlaceOf<Number> place_of(const LoopLink& link, const Kinematics<Number>* parent, const Kinematics<Number>* child) {
  const detail::LoopSide<Number> a = detail::side_of(parent, link.parent, true), b = detail::side_of(child, link.child, true);
  LoopPlaceOf<Number> p;
  p.Ra = a.R, p.xa = a.x, p.xb = b.x;
  p.R = transpose(a.R) * b.R, p.r = transpose_times(a.R, b.x - a.x);
  p.va = a.v, p.wa = a.w, p.vb = b.v, p.wb = b.w;
  return p;
}

// Calls put(row, the row's numbers) for all rows of a loop.
template <class Put>
void each_row(const LoopWorkspace& loops, std::size_t loop, const LoopLink& link, const LoopPlaceOf<Number>& p, const Put& put) {
  const detail::RowAt<Number> at_place(p);
  const auto angle = [&](const Number& si, const Number& co) { return angle_of(si, co, loops.turns[loop].first); };
  detail::closure_rows(
      link.closure, ~0u, p.R, p.r, transpose_times(p.Ra, at_place.relative), angle,
      [&](int k, const Number& phi, const Vector3<Number>& F, const Vector3<Number>& T, const Vector3<Number>& rate) {
        LoopRowOf<Number> row;
        at_place.put(p, phi, F, T, rate, row);
        put(link.first_row + k, row);
      });
}

}  // namespace

void AccelerationTangent::Memory::prepare_loops(Workspace<double>& evaluated) {
  const LoopWorkspace& loops = *evaluated.loops;
  const double* const q = state->q().data();
  const int nv = tree->nv();
  rows = loops.kept.rows;
  const auto n = static_cast<int>(rows.size());
  right.resize(rows.size());
  std::vector<double> J(rows.size() * at(nv));
  std::vector<int> index(at(tree->loops().rows), -1);
  for (int i = 0; i < n; ++i) index[at(rows[at(i)])] = i;
  for (std::size_t i = 0; i < tree->loops().links.size(); ++i) {
    const LoopLink& link = tree->loops().links[i];
    for (int k = 0; k < link.rows; ++k) {
      const int row = index[at(link.first_row + k)];
      if (row < 0) continue;
      double* const own = J.data() + at(row) * at(nv);
      if (link.ends.coupling >= 0) {
        own[tree->first_p(link.ends.joint)] += 1;
        if (link.ends.follows >= 0) own[tree->first_p(link.ends.follows)] -= loops.rows[at(link.first_row)].slope;
        continue;
      }
      const Loop& loop = tree->loops()[i];
      const LoopRow& of = loops.rows[at(link.first_row + k)];
      const auto add = [&](int body, double sign) {
        add_wrench_row(*tree, q, evaluated, body, sign * on_body(evaluated.bodies[at(body)], of.F, of.T, loops.places[i].xb),
                       own);
      };
      add(loop.body, 1);
      if (loop.to >= 0) add(loop.to, -1);
    }
  }
  responses = J;
  DenseMatrix A(n, n);
  for (int i = 0; i < n; ++i) {
    double* const y = responses.data() + at(i) * at(nv);
    solve_with_factors<double>(*tree, q, evaluated, y);
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < nv; ++k) A(j, i) += J[at(j) * at(nv) + at(k)] * y[k];
  }
  factor = cholesky(A);
}

// The wrenches of constant multipliers move with the bodies.
void AccelerationTangent::Memory::add_loop_wrenches() noexcept {
  const LoopWorkspace& loops = *workspace->loops;
  for (std::size_t i = 0; i < tree->loops().links.size(); ++i) {
    const LoopLink& link = tree->loops().links[i];
    if (link.ends.coupling >= 0) {
      const int b = link.ends.follows;
      if (b < 0 || (tree->link(b).locked & 1u) != 0) continue;
      const Number x{state->q()[at(tree->first_q(b))], dq[at(tree->first_p(b))]};
      Lanes& force = da[at(tree->first_p(b))];
      force = force - loops.lambda[at(link.first_row)] * tree->couplings()[at(link.ends.coupling)].slope(x).e;
      continue;
    }
    const Loop& loop = tree->loops()[i];
    const Kinematics<Number> child = located(loop.body), parent = loop.to >= 0 ? located(loop.to) : Kinematics<Number>{};
    const LoopPlaceOf<Number> p = place_of(link, loop.to >= 0 ? &parent : nullptr, &child);
    Vector3<Number> F{}, T{};
    each_row(loops, i, link, p, [&](int row, const LoopRowOf<Number>& numbers) {
      F += loops.lambda[at(row)] * numbers.F, T += loops.lambda[at(row)] * numbers.T;
    });
    BodyTangent& one = bodies[at(loop.body)];
    one.wrench = one.wrench - rate_of(on_body(child, F, T, p.xb));
    if (loop.to >= 0) bodies[at(loop.to)].wrench += rate_of(on_body(parent, F, T, p.xb));
  }
}

void AccelerationTangent::Memory::find_rows(OfRow what) noexcept {
  const LoopWorkspace& loops = *workspace->loops;
  for (Lanes& each : right) each = Lanes(0.0);
  const auto put = [&](int row, const Lanes& value) {
    const auto found = std::lower_bound(rows.begin(), rows.end(), row);
    if (found != rows.end() && *found == row) right[static_cast<std::size_t>(found - rows.begin())] += value;
  };
  for (std::size_t i = 0; i < tree->loops().links.size(); ++i) {
    const LoopLink& link = tree->loops().links[i];
    if (link.ends.coupling >= 0) {
      const CouplingEnds& ends = link.ends;
      const Coupling& coupling = tree->couplings()[at(ends.coupling)];
      const auto number = [&](int b, const double* values, const std::vector<Lanes>& rates) {
        return Number{values[tree->first_p(b)], rates[at(tree->first_p(b))]};
      };
      const auto of_follows = [&](const double* values, const std::vector<Lanes>& rates) {
        return ends.follows >= 0 ? number(ends.follows, values, rates) : Number(0);
      };
      const double *const v = workspace->v.get(), *const a = workspace->a.get();
      const Number x = ends.follows >= 0
                           ? Number{state->q()[at(tree->first_q(ends.follows))], dq[at(tree->first_p(ends.follows))]}
                           : Number(0);
      const Number ratio = coupling.slope(x), rate = of_follows(v, dv);
      Number value = number(ends.joint, v, dv) - ratio * rate;
      if (what == OfRow::residual) value = {0, dq[at(tree->first_p(ends.joint))] - ratio.r * x.e};
      if (what == OfRow::acceleration)
        value = number(ends.joint, a, da) - ratio * of_follows(a, da) - coupling.curvature(x) * rate * rate;
      put(link.first_row, value.e);
      continue;
    }
    const Loop& loop = tree->loops()[i];
    Kinematics<Number> child = located(loop.body), parent = loop.to >= 0 ? located(loop.to) : Kinematics<Number>{};
    const Kinematics<Number>* const outer = loop.to >= 0 ? &parent : nullptr;
    each_row(loops, i, link, place_of(link, outer, &child), [&](int row, const LoopRowOf<Number>& numbers) {
      put(row, what == OfRow::residual ? numbers.residual.e : what == OfRow::velocity ? numbers.velocity.e : numbers.drift.e);
    });
    if (what != OfRow::acceleration) continue;
    // Of the accelerations of bodies, as in gather_loops: they contain what velocities cause beside `drift`.
    const auto acceleration = [&](int b) {
      return with_rate(felt_acceleration(*tree, state->q().data(), *workspace, b), bodies[at(b)].acceleration);
    };
    child.velocity = acceleration(loop.body);
    if (outer != nullptr) parent.velocity = acceleration(loop.to);
    each_row(loops, i, link, place_of(link, outer, &child),
             [&](int row, const LoopRowOf<Number>& numbers) { put(row, numbers.velocity.e); });
  }
}

void AccelerationTangent::Memory::correct(std::vector<Lanes>& to) noexcept {
  const auto n = static_cast<int>(rows.size());
  const int nv = tree->nv();
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) right[at(i)] -= factor(i, k) * right[at(k)];
    right[at(i)] = right[at(i)] / factor(i, i);
  }
  for (int i = n; i-- > 0;) {
    for (int k = i + 1; k < n; ++k) right[at(i)] -= factor(k, i) * right[at(k)];
    right[at(i)] = right[at(i)] / factor(i, i);
  }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < nv; ++k) to[at(k)] -= responses[at(i) * at(nv) + at(k)] * right[at(i)];
}

void AccelerationTangent::Memory::close_accelerations() noexcept {
  find_rows(OfRow::acceleration);
  correct(da);
}

void AccelerationTangent::Memory::close_direction() noexcept {
  outward();
  find_rows(OfRow::residual);
  correct(dq);
  outward();
  find_rows(OfRow::velocity);
  correct(dv);
}

}  // namespace momentree
