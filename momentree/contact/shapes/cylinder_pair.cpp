#include <momentree/contact/shapes/cylinder_pair.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <momentree/contact/candidates_impl.hpp>
#include <momentree/contact/shapes/circle.hpp>

namespace momentree::contact {

namespace {

constexpr double cone_slack = 1e-6;   // of directions between a side and an end
constexpr double thin_ellipse = 0.5;  // a rim is seen along an axis as an ellipse; thinner ones have two sides
constexpr double same_tangent = 1e-4;
constexpr double off_prism = 0.02;    // of the radius: the surface is nearer to the prism than this
constexpr double same_axis = 0.9998;  // cosine of the angle of axes of sides that touch along a line

// A cylinder in the world.
struct Can {
  const Solid& solid;
  const Place& place;
  Vec3 own_axis = normalized(solid.ends[1] - solid.ends[0]);
  double rim = solid.rim, length = norm(solid.ends[1] - solid.ends[0]), slack = edge_slack * solid.reach;
  Vec3 axis = place.R * own_axis;
  std::array<Vec3, 2> ends{out_of(place, solid.ends[0]), out_of(place, solid.ends[1])};
  std::array<Vec3, 2> across{};

  Can(const Solid& s, const Place& p) : solid(s), place(p) { perpendiculars(own_axis, across.data()); }
  Vec3 outward(std::size_t end) const { return end == 0 ? -axis : axis; }
  Vec3 own_outward(std::size_t end) const { return end == 0 ? -own_axis : own_axis; }
  double height(const Vec3& p) const { return dot(axis, p - ends[0]); }
  double beyond(const Vec3& p) const { return std::max(-height(p), height(p) - length); }
  double aside(const Vec3& p) const { return norm(p - ends[0] - height(p) * axis) - rim; }
  bool holds(const Vec3& p) const { return beyond(p) < slack && aside(p) < slack; }
  bool beside(const Vec3& p) const { return beyond(p) < slack; }
  double reach(const Vec3& n) const {
    return 0.5 * dot(n, ends[0] + ends[1]) + 0.5 * length * std::fabs(dot(n, axis)) + rim * norm(cross(n, axis));
  }
  Vec3 on_rim(std::size_t end, double angle) const { return solid.ends[end] + rim * turned(across[0], across[1], angle); }
};

struct CanPair {
  const Can &a, &b;
  bool swapped;  // a is the second solid
  double within;
  std::vector<Candidate>& out;

  void push(const Features& f, std::size_t i, std::size_t k, double gap) const {
    if (gap < within) out.push_back({f, swapped, id_of(f.pair, swapped, i, k), gap});
  }

  // The rims of a before the ends of b.
  void rims_before_ends() const {
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t k = 0; k < 2; ++k) {
        Features f{FeaturePair::circle_plane, a.solid.ends[i], a.own_axis, b.solid.ends[k], b.own_outward(k)};
        f.rim = a.rim;
        const Touch lowest = touch(f, a.place, b.place);
        if (!(lowest.gap < within)) continue;
        if (a.rim * norm(cross(a.axis, b.axis)) >= standing) {
          if (before_end(k, lowest.point)) push(f, i, k, lowest.gap);
          continue;
        }
        if (!(dot(a.outward(i), b.outward(k)) < 0) || lowest.gap < -0.5 * std::min(a.length, b.length)) continue;
        f.pair = FeaturePair::point_plane, f.line_a = {}, f.rim = 0;
        for (std::size_t n = 0; n < points_of_rim; ++n) {
          f.point_a = a.on_rim(i, static_cast<double>(n) * 2 * std::numbers::pi / points_of_rim);
          if (before_end(k, out_of(a.place, f.point_a))) push(f, points_of_rim * i + n, k, lowest.gap);
        }
        if (!swapped) rims_that_cross(i, k, lowest.gap);
      }
  }
  bool before_end(std::size_t k, const Vec3& p) const {
    const double above = dot(b.outward(k), p - b.ends[k]), aside = b.aside(p);
    return aside < b.slack && (above > 0 || (aside <= above + b.slack && above >= -0.5 * b.length));
  }
  // Ends in one plane: where their rims cross, with their tangents.
  void rims_that_cross(std::size_t i, std::size_t k, double gap) const {
    const Vec3 from = a.ends[i] - b.ends[k], n = b.outward(k), flat = from - dot(from, n) * n;
    const double apart = norm(flat);
    if (!(apart > 0)) return;
    const double x = (apart * apart + b.rim * b.rim - a.rim * a.rim) / (2 * apart), square = b.rim * b.rim - x * x;
    if (!(square > 0)) return;
    const Vec3 u = (1 / apart) * flat, w = cross(n, u);
    for (const double sign : {1.0, -1.0}) {
      const Vec3 p = b.ends[k] + x * u + (sign * std::sqrt(square)) * w;
      const Vec3 own_a = into(a.place, p) - a.solid.ends[i], own_b = into(b.place, p) - b.solid.ends[k];
      const Vec3 ra = normalized(own_a - dot(own_a, a.own_axis) * a.own_axis);
      const Vec3 rb = normalized(own_b - dot(own_b, b.own_axis) * b.own_axis);
      Features f{FeaturePair::line_line, a.solid.ends[i] + a.rim * ra, cross(a.own_axis, ra), b.solid.ends[k] + b.rim * rb,
                 cross(b.own_axis, rb)};
      const Vec3 normal = cross(a.place.R * f.line_a, b.place.R * f.line_b);
      if (norm(normal) < same_tangent) continue;
      f.side = dot(normal, n) > 0 ? 1 : -1;
      const double turns = std::atan2(dot(ra, a.across[1]), dot(ra, a.across[0])) / (2 * std::numbers::pi);
      push(f, 2 + i + 4 * static_cast<std::size_t>((turns + 1) * points_of_rim), 2 + k, gap);
    }
  }

  // The rims of a before the side of b.
  void rims_before_side() const {
    for (std::size_t i = 0; i < 2; ++i) {
      const double seen = std::fabs(dot(a.axis, b.axis));
      if (a.rim * seen < standing) {
        end_on_side(i);
        continue;
      }
      Features f = rim_before_side(i);
      if (!nearest_to_line(a.ends[i] - b.ends[0], a.outward(i), a.rim, b.axis, f.side > 0).found) continue;
      const Touch t = touch(f, a.place, b.place);
      if (!(t.gap < within) || !(t.gap + b.rim > 0) || dot(t.normal, a.outward(i)) > cone_slack || !b.beside(t.point)) continue;
      push(f, i, 0, t.gap);
    }
  }
  Features rim_before_side(std::size_t i) const {
    Features f{FeaturePair::circle_line, a.solid.ends[i], a.own_outward(i), b.solid.ends[0], b.own_axis, 0, b.rim};
    f.rim = a.rim, f.side = std::fabs(dot(a.axis, b.axis)) < thin_ellipse ? 1 : 0;
    return f;
  }
  // An end that lies on the side touches it between two points of the rim.
  void end_on_side(std::size_t i) const {
    const Vec3 n = a.outward(i), from = a.ends[i] - b.ends[0];
    const double middle = dot(b.axis, from);
    const Vec3 off = from - middle * b.axis;
    const double aside = norm(off - dot(off, n) * n), half = std::sqrt(std::max(0.0, a.rim * a.rim - aside * aside));
    if (!(half > same_tangent * a.rim) || !(dot(off, n) < 0)) return;
    double lowest = HUGE_VAL;
    std::array<Features, 2> found{};
    std::array<std::size_t, 2> sector{};
    std::size_t count = 0;
    for (const double s : {middle - half, middle + half}) {
      if (s < -b.slack || s > b.length + b.slack) continue;
      const Vec3 p = into(a.place, b.ends[0] + s * b.axis) - a.solid.ends[i];
      const Vec3 radial = normalized(p - dot(p, a.own_axis) * a.own_axis);
      Features f{FeaturePair::line_line,
                 a.solid.ends[i] + a.rim * radial,
                 cross(a.own_axis, radial),
                 b.solid.ends[0],
                 b.own_axis,
                 0,
                 b.rim};
      f.side = dot(cross(a.place.R * f.line_a, b.axis), n) < 0 ? 1 : -1;
      lowest = std::min(lowest, touch(f, a.place, b.place).gap);
      const double turns = std::atan2(dot(radial, a.across[1]), dot(radial, a.across[0])) / (2 * std::numbers::pi);
      sector[count] = static_cast<std::size_t>((turns + 1) * points_of_rim);
      found[count++] = f;
    }
    for (std::size_t m = 0; m < count; ++m) push(found[m], 2 + i + 4 * sector[m], 1, lowest);
  }

  void sides() const {
    const Vec3 normal = cross(a.axis, b.axis);
    if (norm(normal) < parallel) return;
    Features f{FeaturePair::line_line, a.solid.ends[0], a.own_axis, b.solid.ends[0], b.own_axis, a.rim, b.rim};
    f.side = dot(normal, a.ends[0] - b.ends[0]) < 0 ? -1 : 1;
    const Along where = nearest_along(f, a.place, b.place);
    if (where.a < -a.slack || where.a > a.length + a.slack || where.b < -b.slack || where.b > b.length + b.slack) return;
    push(f, 0, 0, touch(f, a.place, b.place).gap);
  }

  void rims() const {
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t k = 0; k < 2; ++k)
        for (const double side : {1.0, -1.0}) {
          const Features f = rim_before_rim(i, k, side);
          if (!nearest_of_circles(a.ends[i] - b.ends[k], a.outward(i), a.rim, b.outward(k), b.rim, side).found) continue;
          const Touch t = touch(f, a.place, b.place);
          if (!(t.gap < within) || dot(t.normal, a.outward(i)) > cone_slack || dot(t.normal, b.outward(k)) < -cone_slack)
            continue;
          const Vec3 on_b = t.point - t.gap * t.normal;
          if (dot(t.normal, t.point - a.ends[i]) > cone_slack * a.rim || dot(t.normal, on_b - b.ends[k]) < -cone_slack * b.rim)
            continue;
          if (t.gap < 0 && !(a.holds(on_b) && b.holds(t.point))) continue;
          push(f, 2 * i + k + (side > 0 ? 4 : 8), 1, t.gap);
        }
  }
  Features rim_before_rim(std::size_t i, std::size_t k, double side) const {
    Features f{FeaturePair::circle_line, a.solid.ends[i], a.own_outward(i), b.solid.ends[k], b.own_outward(k)};
    f.rim = a.rim, f.length = b.rim, f.side = side;
    return f;
  }

  // Of a above b along n.
  double apart_along(const Vec3& n) const { return -a.reach(-n) - b.reach(n); }
};

struct Best {
  Features features{};
  bool swapped = false, end = false;
  std::size_t k = 0;
  double gap = -HUGE_VAL;
};

// The direction in which the cylinders are farthest apart, or overlap least: among those of all features.
struct Directions {
  const CanPair &ab, &ba;
  Best best{}, best_end{};

  void look(const CanPair& pair, const Features& f, const Touch& t, double slack) {
    if (!(t.gap > best.gap) || !pair.a.beside(t.point) || std::fabs(pair.apart_along(t.normal) - t.gap) > slack) return;
    best = {f, pair.swapped, false, 0, t.gap};
  }
  void find() {
    const double slack = 1e-9 * (ab.a.solid.reach + ab.b.solid.reach);
    for (const CanPair* pair : {&ab, &ba}) {
      for (std::size_t k = 0; k < 2; ++k)
        if (const double gap = pair->apart_along(pair->b.outward(k)); gap > best_end.gap)
          best_end = {{}, pair->swapped, true, k, gap};
      for (std::size_t i = 0; i < 2; ++i) {
        const Features f = pair->rim_before_side(i);
        if (!nearest_to_line(pair->a.ends[i] - pair->b.ends[0], pair->a.outward(i), f.rim, pair->b.axis, f.side > 0).found)
          continue;
        const Touch t = touch(f, pair->a.place, pair->b.place);
        if (pair->b.beside(t.point)) look(*pair, f, t, slack);
      }
    }
    if (norm(cross(ab.a.axis, ab.b.axis)) > parallel)
      for (const double side : {1.0, -1.0}) {
        Features f{FeaturePair::line_line, ab.a.solid.ends[0], ab.a.own_axis, ab.b.solid.ends[0],
                   ab.b.own_axis,          ab.a.rim,           ab.b.rim};
        f.side = side;
        const Touch t = touch(f, ab.a.place, ab.b.place);
        if (ab.b.beside(t.point)) look(ab, f, t, slack);
      }
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t k = 0; k < 2; ++k)
        for (const double side : {1.0, -1.0}) {
          const Features f = ab.rim_before_rim(i, k, side);
          if (nearest_of_circles(ab.a.ends[i] - ab.b.ends[k], ab.a.outward(i), ab.a.rim, ab.b.outward(k), ab.b.rim, side).found)
            look(ab, f, touch(f, ab.a.place, ab.b.place), slack);
        }
  }
  double gap() const { return std::max(best.gap, best_end.gap); }
};

void push_stepped(const CanPair& pair, const Features& f) {
  const double gap = touch(f, pair.a.place, pair.b.place).gap;
  if (gap < pair.within)
    pair.out.push_back({f, pair.swapped, id_of(f.pair, pair.swapped, pair.out.size(), 0) | std::uint64_t{1} << 63, gap});
}

// Points of a before an end of b.
void points_before_end(const CanPair& pair, std::size_t k) {
  const Can &a = pair.a, &b = pair.b;
  const Vec3 n = b.outward(k);
  const double upright = dot(n, a.axis), tilt = norm(cross(n, a.axis));
  const std::size_t end = upright > 0 ? 0 : 1, first = pair.out.size();
  Features f{FeaturePair::circle_plane, a.solid.ends[end], a.own_axis, b.solid.ends[k], b.own_outward(k)};
  f.rim = a.rim;
  const Features lowest = f;
  const auto flat = [&](const Vec3& world) { return world - b.ends[k] - dot(world - b.ends[k], n) * n; };
  if (std::fabs(upright) < tilt) {
    f.point_a = a.solid.ends[0];
    const Vec3 low = flat(touch(f, a.place, b.place).point);
    f.point_a = a.solid.ends[1];
    const Part part = in_disc(low, flat(touch(f, a.place, b.place).point) - low, b.rim);
    for (const double s : {part.from, part.to}) {
      if (part.from > part.to) break;
      f.point_a = a.solid.ends[0] + s * (a.solid.ends[1] - a.solid.ends[0]);
      push_stepped(pair, f);
    }
  } else {
    const bool stands = a.rim * tilt < standing;
    const auto point = [&](const Vec3& p) {
      f.pair = FeaturePair::point_plane, f.point_a = p, f.line_a = {}, f.rim = 0;
      push_stepped(pair, f);
    };
    if (!stands && b.aside(touch(lowest, a.place, b.place).point) < b.slack) push_stepped(pair, lowest);
    const Vec3 down = transpose_times(a.place.R, n);
    for (std::size_t i = 0; i < points_of_rim; ++i) {
      const double angle = static_cast<double>(i) * 2 * std::numbers::pi / points_of_rim;
      const Vec3 p = a.on_rim(end, angle);
      if (b.aside(out_of(a.place, p)) < b.slack) point(p);
      // The rim of b, seen along the normal.
      const Vec3 own = into(a.place, out_of(b.place, b.on_rim(k, angle))) - a.solid.ends[end];
      const Vec3 there = own - (dot(own, a.own_axis) / dot(down, a.own_axis)) * down;
      if (norm(there) < a.rim) point(a.solid.ends[end] + there);
    }
  }
  if (pair.out.size() == first) push_stepped(pair, lowest);
}

void points_at_sides(const CanPair& pair, const Best& best) {
  const Can &a = pair.a, &b = pair.b;
  const double cosine = dot(a.axis, b.axis);
  if (std::fabs(cosine) > same_axis && best.features.length == 0) {
    double low = a.height(b.ends[0]), high = a.height(b.ends[1]);
    if (low > high) std::swap(low, high);
    low = std::clamp(low, 0.0, a.length), high = std::clamp(high, 0.0, a.length);
    if (high > low) {
      Features f = pair.rim_before_side(1);
      for (const double height : {low, high}) f.point_a = a.solid.ends[0] + height * a.own_axis, push_stepped(pair, f);
      return;
    }
  }
  push_stepped(pair, best.features);
}

// The rims, by a search around the first one: far apart they are not near where one passes through the plane of the other.
void rims_far_apart(const Can& a, const Can& b, NearestPoints& best) {
  constexpr int samples = 64;
  constexpr double step = 2 * std::numbers::pi / samples, golden = 0.6180339887498949;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 2; ++k) {
      Vec3 on_a, on_b;
      const auto at_angle = [&](double angle) {
        on_a = out_of(a.place, a.on_rim(i, angle));
        const Vec3 from = on_a - b.ends[k], flat = from - dot(from, b.axis) * b.axis;
        on_b = b.ends[k] + (b.rim / norm(flat)) * flat;
        return norm(on_a - on_b);
      };
      std::array<double, samples> all{};
      for (int n = 0; n < samples; ++n) all[static_cast<std::size_t>(n)] = at_angle(n * step);
      for (std::size_t n = 0; n < samples; ++n) {
        if (all[n] > all[(n + 1) % samples] || all[n] > all[(n + samples - 1) % samples]) continue;
        double low = (static_cast<double>(n) - 1) * step, high = low + 2 * step;
        while (high - low > 1e-9) {
          const double x = high - golden * (high - low), y = low + golden * (high - low);
          (at_angle(x) < at_angle(y) ? high : low) = at_angle(x) < at_angle(y) ? y : x;
        }
        const double distance = at_angle(0.5 * (low + high));
        if (distance < best.distance) best = {distance, on_a, on_b, (1 / distance) * (on_a - on_b)};
      }
    }
}

}  // namespace

void cylinders_face(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                    std::vector<Candidate>& out) {
  const Can a(one, place_one), b(other, place_other);
  const CanPair ab{a, b, false, within, out}, ba{b, a, true, within, out};
  const std::size_t first = out.size();
  for (const CanPair* pair : {&ab, &ba}) pair->rims_before_ends(), pair->rims_before_side();
  ab.sides();
  ab.rims();
  if (std::any_of(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(), [](const Candidate& c) { return c.gap < 0; }))
    return;
  // Deep overlaps may have none of these features. Far apart that is the rule, and the prisms are so, too.
  if (distance_of_polyhedra(one, place_one, other, place_other).distance > off_prism * (one.rim + other.rim)) return;
  cylinders_overlap_points(one, place_one, other, place_other, 0, out);
}

void cylinders_overlap_points(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other,
                              double within, std::vector<Candidate>& out) {
  const Can a(one, place_one), b(other, place_other);
  const CanPair ab{a, b, false, within, out}, ba{b, a, true, within, out};
  Directions all{ab, ba};
  all.find();
  if (all.gap() > within) return;
  const double more = nearly_parallel * std::min(one.thickness, other.thickness), end = all.best_end.gap;
  const bool at_side = all.best.gap > std::max(clearly_less * end, end) + more;
  const Best& best = at_side ? all.best : all.best_end;
  const CanPair& pair = best.swapped ? ba : ab;
  if (at_side)
    points_at_sides(pair, best);
  else
    points_before_end(pair, best.k);
}

NearestPoints cylinders_distance(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other) {
  std::vector<Candidate> features;
  cylinders_face(one, place_one, other, place_other, HUGE_VAL, features);
  NearestPoints best;
  best.distance = HUGE_VAL;
  for (const Candidate& c : features) {
    const Touch t = touch(c.features, c.swapped ? place_other : place_one, c.swapped ? place_one : place_other);
    if (!(t.gap < best.distance)) continue;
    const Vec3 on_b = t.point - t.gap * t.normal;
    best = c.swapped ? NearestPoints{t.gap, on_b, t.point, -t.normal} : NearestPoints{t.gap, t.point, on_b, t.normal};
  }
  const Can a(one, place_one), b(other, place_other);
  const CanPair ab{a, b, false, 0, features};
  if (best.distance > 0 && !(std::fabs(ab.apart_along(best.normal) - best.distance) < 1e-12 * (one.reach + other.reach)))
    rims_far_apart(a, b, best);
  if (best.distance < 0) best.distance = 0, best.normal = {}, best.on_one = best.on_other = 0.5 * (best.on_one + best.on_other);
  return best;
}

}  // namespace momentree::contact
