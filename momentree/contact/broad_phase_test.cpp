// Balls that overlap, against all pairs.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
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

TEST_CASE("contact broad phase: ten thousand balls, against a search in cells") {
  oracle::Prng random(13);
  constexpr double size = 20, cell = 0.5;  // at least the largest diameter
  BroadPhase broad_phase;
  std::vector<contact::Ball> balls;
  for (int i = 0; i < 10000; ++i) balls.push_back({random.vector(size / 2), random.uniform(0.1, cell / 2)});
  for (int k = 0; k < 4; ++k) {
    std::map<std::array<int, 3>, std::vector<int>> cells;
    const auto cell_of = [](const Vec3& p) {
      return std::array<int, 3>{static_cast<int>(std::floor(p.x / cell)), static_cast<int>(std::floor(p.y / cell)),
                                static_cast<int>(std::floor(p.z / cell))};
    };
    for (int i = 0; i < 10000; ++i) cells[cell_of(balls[static_cast<std::size_t>(i)].centre)].push_back(i);
    std::vector<std::pair<int, int>> expected;
    for (int i = 0; i < 10000; ++i) {
      const contact::Ball& a = balls[static_cast<std::size_t>(i)];
      const std::array<int, 3> at = cell_of(a.centre);
      for (int n = 0; n < 27; ++n) {
        const auto near = cells.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
        if (near == cells.end()) continue;
        for (const int j : near->second) {
          const contact::Ball& b = balls[static_cast<std::size_t>(j)];
          if (j > i && dot(a.centre - b.centre, a.centre - b.centre) <= (a.radius + b.radius) * (a.radius + b.radius))
            expected.emplace_back(i, j);
        }
      }
    }
    std::sort(expected.begin(), expected.end());
    const auto pairs = broad_phase.find(balls);
    CHECK(std::vector<std::pair<int, int>>(pairs.begin(), pairs.end()) == expected);
    CHECK(expected.size() > 1000);
    for (contact::Ball& ball : balls) ball.centre += random.vector(k == 1 ? 2 : 0.05);
  }
}
