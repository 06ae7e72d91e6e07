// Stacks of boxes that begin to slip, against closed forms: on the floor, on each other, or both with equal friction.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// Boxes on the floor and on each other, from below; `friction`: of each with what is under it.
struct Stack {
  std::vector<double> masses, offsets, friction;
};

constexpr double g = 5, height = 0.1;

Simulation simulation(const Stack& stack, const Integration& integration) {
  Model model({.gravity = {0, 0, -g}});
  model.add_collider({.plane = true});
  BodyId below = ground;
  for (std::size_t i = 0; i < stack.masses.size(); ++i) {
    const double m = stack.masses[i], z = height * (0.5 + static_cast<double>(i)), friction = stack.friction[i];
    const BodyId body = model.add({.name = "box" + std::to_string(i),
                                   .mass = m,
                                   .inertia = diagonal(0.01 * m, 0.01 * m, 0.018 * m),
                                   .joint = Free{},
                                   .q = {stack.offsets[i], 0, z, 1, 0, 0, 0}});
    model.add_collider({.body = body, .solid = contact::box({0.4, 0.4, height})});
    model.add_contact_rule({.one = {body}, .other = {below}, .law = {.friction = friction, .static_friction = friction}});
    below = body;
  }
  return Simulation(model, integration);
}

// The accelerations along gravity's part in the plane, with which each box follows the one below it if friction allows.
std::vector<double> accelerations(const Stack& stack, double along) {
  const std::size_t n = stack.masses.size();
  std::vector<double> a(n, 0.0);
  std::vector<bool> slips(n, false);
  const auto above = [&](std::size_t i) {
    double sum = 0;
    for (std::size_t k = i; k < n; ++k) sum += stack.masses[k];
    return sum;
  };
  // Boxes that stay together are one. Of the groups, the one whose limit is exceeded most slips first.
  for (std::size_t round = 0; round <= n; ++round) {
    for (std::size_t i = 0; i < n;) {
      std::size_t end = i + 1;
      while (end < n && !slips[end]) ++end;
      double mass = 0, force = 0;
      for (std::size_t k = i; k < end; ++k) mass += stack.masses[k];
      force = mass * along;
      if (end < n) force += stack.friction[end] * above(end) * g;
      if (slips[i]) force -= stack.friction[i] * above(i) * g;
      for (std::size_t k = i; k < end; ++k) a[k] = i == 0 && !slips[0] ? 0 : force / mass;
      i = end;
    }
    double worst = 1e-9;
    std::size_t next = n;
    double force = 0;
    for (std::size_t i = n; i-- > 0;) {  // what the box below has to hold
      force += stack.masses[i] * (along - a[i]);
      const double excess = force - stack.friction[i] * above(i) * g;
      if (!slips[i] && excess > worst) worst = excess, next = i;
    }
    if (next == n) return a;
    slips[next] = true;
  }
  FAIL("no accelerations found");
  return a;
}

struct Deviation {
  double motion = 0, turn = 0;
};
// Of the velocities after a time t at most, in m/s and rad/s.
Deviation deviation(const Simulation& sim, const std::vector<double>& a, const Vec3& direction, double t) {
  Deviation worst;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const BodyMotion& motion = sim.world().motions()[i];
    worst.motion = std::max(worst.motion, norm(motion.linear - a[i] * t * direction));
    worst.turn = std::max(worst.turn, norm(motion.angular));
  }
  return worst;
}

}  // namespace

TEST_CASE("contact: stacks begin to slip, with equal friction or not, as in closed form, without turning") {
  std::mt19937 random(4711);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  for (int k = 0; k < 12; ++k) {
    Stack stack;
    const int boxes = k % 6 == 1 ? 3 : 2;
    const double equal = uniform(0.2, 0.7);
    for (int i = 0; i < boxes; ++i) {
      stack.masses.push_back(uniform(0.5, 3)), stack.offsets.push_back(uniform(-0.03, 0.03));
      stack.friction.push_back(k % 3 == 0 ? uniform(0.2, 0.7) : equal);
    }
    const double tilt = *std::min_element(stack.friction.begin(), stack.friction.end()) * uniform(1.01, 1.2);
    const double turned = uniform(0, 6.28);
    const Vec3 direction{std::cos(turned), std::sin(turned), 0};
    const std::vector<double> a = accelerations(stack, g * tilt);
    CAPTURE(k);
    for (const char* method : {"rk4", "dopri5"}) {
      CAPTURE(method);
      Simulation sim = simulation(stack, {.method = method, .step = 1e-3});
      REQUIRE(sim.run_until(2e-3));
      sim.set_gravity(Vec3{0, 0, -g} + g * tilt * direction);
      for (int i = 0; i < boxes; ++i) {
        const auto& now = sim.world().accelerations()[static_cast<std::size_t>(i)];
        CHECK(norm(now.linear - a[static_cast<std::size_t>(i)] * direction) < 1e-4);
        CHECK(norm(now.angular) < 1e-3);
      }
      for (const double t : {1e-5, 1e-4, 1e-3}) {
        CAPTURE(t);
        REQUIRE(sim.run_until(2e-3 + t));
        const Deviation now = deviation(sim, a, direction, t);
        CHECK(now.motion < 1e-4 * t);
        CHECK(now.turn < 1e-3 * t);
      }
      CHECK(sim.events().size() < 20);
    }
  }
}
