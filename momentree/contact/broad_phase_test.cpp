// Balls that overlap, against all pairs.
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/broad_phase.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;

TEST_CASE("contact broad phase: it finds all pairs that overlap, in order, as balls move, come and go") {
  oracle::Prng random(12);
  BroadPhase broad_phase;
  std::vector<contact::Ball> balls;
  std::size_t found = 0;
  for (int k = 0; k < 300; ++k) {
    if (k % 50 == 0) {
      balls.clear();
      for (int i = random.integer(0, 120); i > 0; --i) balls.push_back({random.vector(2), random.uniform(0, 0.5)});
    }
    for (contact::Ball& ball : balls) ball.centre += random.vector(0.05);
    if (k % 7 == 0 && !balls.empty()) balls.front() = balls.back();
    std::vector<std::pair<int, int>> expected;
    for (int i = 0; i < static_cast<int>(balls.size()); ++i)
      for (int j = i + 1; j < static_cast<int>(balls.size()); ++j) {
        const contact::Ball &a = balls[static_cast<std::size_t>(i)], &b = balls[static_cast<std::size_t>(j)];
        if (dot(a.centre - b.centre, a.centre - b.centre) <= (a.radius + b.radius) * (a.radius + b.radius))
          expected.emplace_back(i, j);
      }
    const auto pairs = broad_phase.find(balls);
    CHECK(std::vector<std::pair<int, int>>(pairs.begin(), pairs.end()) == expected);
    found += expected.size();
  }
  CHECK(found > 1000);
}
