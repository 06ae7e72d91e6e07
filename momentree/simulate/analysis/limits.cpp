#include <momentree/simulate/analysis/limits.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/contacts/contacts.hpp>

namespace momentree::analysis {

namespace {

constexpr double taut = 1e-9;  // of 1 m + the length of a cable

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// Calls f(number, length, length when taut, the change of the length with displacements).
template <class F>
void each_cable(Configuration& at_rest, const F& f) {
  const Tree& tree = at_rest.tree();
  Workspace<double>& workspace = at_rest.workspace();
  for (int s = 0; s < tree.springs().count(); ++s) {
    const Spring& cable = tree.springs()[at(s)];
    if (!cable.inextensible || tree.springs().broken(s)) continue;
    locate_bodies(tree, at_rest.state(), workspace);
    const SpringMotion motion = spring_motion(tree, workspace, s);
    std::vector<double> row(at(at_rest.nv()));
    const auto add = [&](const SpringEnd& end, const Vec3& place, double sign) {
      if (end.body != ground)
        add_contact_row(tree, at_rest.q().data(), workspace, end.body.index, motion.direction, place, sign, row.data());
    };
    add(cable.from, motion.from, -1), add(cable.to, motion.to, 1);
    f(s, motion.length, tree.springs().law(s).rest, row);
  }
}

std::vector<Limit> reached_limits(Configuration& at_rest) {
  std::vector<Limit> reached;
  const auto n = at(at_rest.nv());
  each_coordinate(at_rest.tree(), [&](int b, int dof, int p, int q) {
    const Bounds bounds = bounds_of(at_rest.tree(), b, dof);
    const double x = at_rest.q()[at(q)];
    if (x > bounds.lower && x < bounds.upper) return;
    Limit limit{std::vector<double>(n), p};
    limit.row[at(p)] = x <= bounds.lower ? -1 : 1;
    reached.push_back(std::move(limit));
  });
  each_cable(at_rest, [&](int s, double length, double most, std::vector<double>& row) {
    if (length >= most - taut * (1 + most)) reached.push_back({std::move(row), -1, s});
  });
  return reached;
}

/// P − P M⁻¹ Jᵀ (J P M⁻¹ Jᵀ)⁻¹ J P, with the rows J of some limits.
DenseMatrix projection_with(const DenseMatrix& P, const DenseMatrix& M, const std::vector<const Limit*>& holding) {
  const auto r = static_cast<int>(holding.size());
  if (r == 0) return P;
  DenseMatrix response(P.rows, r), square(r, r);  // P M⁻¹ Jᵀ
  for (int k = 0; k < r; ++k) {
    const std::vector<double> column = P * least_squares(M, holding[at(k)]->row);
    for (int i = 0; i < P.rows; ++i) response(i, k) = column[at(i)];
    for (int i = 0; i < r; ++i) square(i, k) = dot(holding[at(i)]->row, column);
  }
  DenseMatrix result = P;
  std::vector<double> right(at(r)), column(at(P.rows));
  for (int j = 0; j < P.columns; ++j) {
    for (int i = 0; i < P.rows; ++i) column[at(i)] = P(i, j);
    for (int k = 0; k < r; ++k) right[at(k)] = dot(holding[at(k)]->row, column);
    const std::vector<double> impulses = least_squares(square, right, 1e-10);  // limits may be redundant
    for (int i = 0; i < P.rows; ++i)
      for (int k = 0; k < r; ++k) result(i, j) -= response(i, k) * impulses[at(k)];
  }
  return result;
}

}  // namespace

Held find_held(Configuration& at_rest, const std::vector<double>& a) {
  const DenseMatrix P = at_rest.projection(), M = at_rest.mass();
  std::vector<Limit> reached = reached_limits(at_rest);
  std::vector<bool> holds(reached.size());
  const auto projection = [&] {
    std::vector<const Limit*> holding;
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (holds[i]) holding.push_back(&reached[i]);
    return projection_with(P, M, holding);
  };
  double size = 0;
  for (const double each : a) size = std::max(size, std::fabs(each));
  const auto violated = [&](std::size_t i, const std::vector<double>& by) { return dot(reached[i].row, by) > 1e-11 * size; };
  DenseMatrix now = P;
  for (std::size_t round = 0; round < 4 * reached.size(); ++round) {
    const std::vector<double> held = now * a;
    std::size_t worst = reached.size();
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (!holds[i] && violated(i, held) &&
          (worst == reached.size() || dot(reached[i].row, held) > dot(reached[worst].row, held)))
        worst = i;
    if (worst == reached.size()) break;
    holds[worst] = true;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (!holds[i] || i == worst) continue;
      holds[i] = false;  // would it be violated without holding?
      holds[i] = violated(i, projection() * a);
    }
    now = projection();
  }
  Held held{{}, std::move(now)};
  for (std::size_t i = 0; i < reached.size(); ++i)
    if (holds[i]) held.limits.push_back(std::move(reached[i]));
  return held;
}

std::vector<double> held_accelerations(Configuration& at_rest, const Held& held) {
  std::vector<Limit> here = held.limits;
  each_cable(at_rest, [&](int s, double, double, const std::vector<double>& row) {
    for (Limit& limit : here)
      if (limit.cable == s) limit.row = row;
  });
  std::vector<const Limit*> holding;
  for (const Limit& limit : here) holding.push_back(&limit);
  const std::vector<double> a = at_rest.accelerations();
  return projection_with(at_rest.projection(), at_rest.mass(), holding) * a;
}

double part_to_limits(Configuration& at_rest, const std::vector<double>& step) {
  double part = 1;
  each_coordinate(at_rest.tree(), [&](int b, int dof, int p, int q) {
    const Bounds bounds = bounds_of(at_rest.tree(), b, dof);
    const double x = at_rest.q()[at(q)], by = step[at(p)];
    if (x < bounds.upper && x + part * by > bounds.upper) part = (bounds.upper - x) / by;
    if (x > bounds.lower && x + part * by < bounds.lower) part = (bounds.lower - x) / by;
  });
  each_cable(at_rest, [&](int, double length, double most, const std::vector<double>& row) {
    const double by = dot(row, step);
    if (length < most - taut * (1 + most) && length + part * by > most) part = (most - length) / by;
  });
  return part;
}

int stretched_cable(Configuration& at_rest) {
  constexpr double too_long = 1e-8;  // as of overlap(): more is not rounding
  int found = -1;
  each_cable(at_rest, [&](int s, double length, double most, const std::vector<double>&) {
    if (length > most + too_long * (1 + most)) found = s;
  });
  return found;
}

bool shorten_cables(Configuration& at_rest) {
  for (int k = 0; k < 20; ++k) {
    std::vector<double> move(at(at_rest.nv()));
    bool any = false;
    each_cable(at_rest, [&](int, double length, double most, const std::vector<double>& row) {
      if (any || !(length > most + 1e-13 * (1 + most))) return;
      any = true;
      const std::vector<double> response = at_rest.projection() * least_squares(at_rest.mass(), row);
      const double mobility = dot(row, response);
      for (std::size_t i = 0; i < move.size(); ++i) move[i] = (most - length) / mobility * response[i];
    });
    if (!any) return true;
    if (!std::all_of(move.begin(), move.end(), [](double x) { return std::isfinite(x); }) || !at_rest.displace(move))
      return false;
  }
  return false;
}

}  // namespace momentree::analysis
