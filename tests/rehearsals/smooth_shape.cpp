// Compiled with smooth_shape.patch: bodies of a new smooth shape rest, rock and touch others as they should.
#include <numbers>

#include <momentree/contact/shapes/distance.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>

#include "shape_checks.hpp"

using namespace momentree;

namespace {

const contact::Egg egg{0.2, 0.15, 0.1};
const double height = egg.below + 0.375 * (egg.above - egg.below);  // of its centre of mass, upright

// ∫ dV, ∫ z dV, ∫ x² dV and ∫ z² dV by discs.
void check_uniform() {
  constexpr int n = 100'000;
  const double step = (egg.above + egg.below) / n;
  double volume = 0, first = 0, across = 0, along = 0;
  for (int i = 0; i < n; ++i) {
    const double from_circle = (i + 0.5) * step - egg.below, z = from_circle + egg.below - height;
    const double share = from_circle / (from_circle > 0 ? egg.above : egg.below),
                 r2 = egg.radius * egg.radius * (1 - share * share);
    const double disc = std::numbers::pi * r2 * step;
    volume += disc, first += disc * z, across += disc * r2 / 4, along += disc * z * z;
  }
  const contact::UniformBody body = egg.uniform();
  check(near(body.volume, volume, 1e-8 * volume), "volume");
  check(near(first, 0, 1e-8 * volume * egg.radius), "centre of mass");
  check(near(body.moments.z, 2 * across, 1e-8 * body.moments.z), "moment of inertia about z");
  check(near(body.moments.x, across + along, 1e-8 * body.moments.x), "moment of inertia about x");
}

// The rate of the farthest point is its difference quotient, and perpendicular to n.
void check_surface() {
  const contact::Solid solid = contact::solid(egg, {});
  for (int i = 0; i < 100; ++i) {
    const double a = 0.1 * i, b = 0.37 * i, step = 1e-6;
    const Vec3 n{std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b)};
    if (std::fabs(n.z) < 1e-3) continue;
    Vec3 turn[2];
    contact::perpendiculars(n, turn);
    const auto farthest = [&](double by) { return egg.farthest(solid.axes, normalized(n + by * turn[0])); };
    const Vec3 rate = egg.farthest_rate(solid.axes, n, turn[0]);
    check(norm((0.5 / step) * (farthest(step) - farthest(-step)) - rate) < 1e-8 && std::fabs(dot(n, rate)) < 1e-14, "a rate");
  }
}

// Of the centre of mass above a floor, turned about y.
double height_at(double angle) {
  const Vec3 down{std::sin(angle), 0, -std::cos(angle)};  // in its frame
  return dot(down, egg.farthest(contact::solid(egg, {}).axes, down));
}

void check_motion() {
  for (const char* method : {"dop853", "stepping"}) {
    Simulation sim(on_floor(egg, {{0, 0, height + 0.1}, {}}, 0.5), {.method = method, .step = 1e-3});
    check(bool(sim.run_until(0.5)), "a fall");
    check(near(sim.world().motions()[0].pose.position.z, height, 1e-9), std::string("height at rest, ") + method);
  }
  // Without slip it rocks about y: ω² = m g (ρ − h)/(I + m h²), where ρ = a²/c is the radius of curvature at the lowest point.
  const contact::UniformBody uniform = egg.uniform();
  const double mass = density * uniform.volume, I = density * uniform.moments.y, curvature = egg.radius * egg.radius / egg.below;
  const double rate = std::sqrt(mass * g * (curvature - height) / (I + mass * height * height)), angle = 1e-4;
  Simulation sim(on_floor(egg, {{0, 0, height_at(angle)}, from_axis_angle({0, 1, 0}, angle)}, 1),
                 {.method = "dop853", .rtol = 1e-12, .atol = 1e-14});
  check(bool(sim.run_until(1.5 * std::numbers::pi / rate)), "rocking");
  check(near(std::fabs(sim.world().motions()[0].angular.y), angle * rate, 1e-6 * angle * rate + 1e-9), "the rate of rocking");
  check(near(log_rotation(sim.world().motions()[0].pose.rotation).y, 0, 1e-6 * angle + 1e-10), "the period of rocking");
  // From a fall it rolls and slips until it lies still, upright.
  Simulation fallen(on_floor(egg, {{0, 0, 0.5}, from_axis_angle({0.6, 0.8, 0}, 0.4)}, 0.5), {.method = "stepping", .step = 1e-3});
  check(bool(fallen.run_until(4)), "a fall on its side");
  const EnergyBalance balance = fallen.energy();
  check(balance.final < balance.initial && fallen.world().gap(BodyId{0}, ground)->distance > -1e-4, "losses of energy");
}

void check_pairs() {
  contact::each_primitive([](const auto& other) {
    check_pair(other, -contact::distance_to_plane(contact::solid(other, {}), {}, {}, {0, 0, -1}).distance, egg, height);
  });
}

void check_documents() {
  const Pose at{{1, 2, 3}, from_rpy(0.1, 0.2, 0.3)};
  const auto placed = contact::primitive_of(contact::solid(egg, at));
  const auto* const same = placed ? std::get_if<contact::Egg>(&placed->shape) : nullptr;
  check(same != nullptr && near(same->below, egg.below, 1e-14) && norm(placed->at.position - at.position) < 1e-14,
        "its collider");
  double lowest = 0;
  for (const Vec3& p : io::surface_of(contact::solid(egg, {})).points) lowest = std::fmin(lowest, p.z);
  check(near(lowest, -height, 1e-12), "triangles");
}

}  // namespace

int main() {
  check_uniform();
  check_surface();
  check_motion();
  check_pairs();
  check_documents();
  return check(true, "");
}
