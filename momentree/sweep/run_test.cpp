#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <momentree/scenario/test_support.hpp>
#include <momentree/sweep/run.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/text/diagnostic.hpp>
#include <momentree/text/files/text_file.hpp>

using namespace momentree;
using namespace momentree::sweep;

namespace {

struct Folder : io::test::TemporaryFolder {
  Folder() {
    io::write_text_file(*this / "ball.toml",
                        "format = 1\n[world]\ngravity = [0, -10, 0]\n[[mechanism]]\nname = \"m\"\nroot = \"free\"\n"
                        "[[mechanism.body]]\nname = \"ball\"\nmass = 2\ninertia = 1\n[integrate]\nstep = 0.01\nuntil = 1\n");
  }
};

}  // namespace

TEST_CASE("a sweep runs in memory, with the numbers of its worlds alone") {
  const Folder folder;
  io::write_text_file(folder / "s.toml",
                      "format = 1\nscenario = \"ball.toml\"\nworlds = 50\n[vary]\n"
                      "\"mechanism.m.state.velocity.linear\" = { uniform = [[1, 3, -1], [2, 6, 1]] }\n"
                      "\"mechanism.m.body.ball.mass\" = { normal = [1, 1.5] }\n"
                      "[measure]\ny = { final = \"m/ball.y\" }\n");
  const Sweep sweep = load(folder / "s.toml");
  for (const int threads : {0, 1, 3}) {
    const SweepResults results = run(sweep, {.threads = threads});
    CHECK(results.complete);
    REQUIRE(results.measures.size() == 50);
    REQUIRE(results.values.size() == 200);
    std::size_t failed = 0;
    for (std::size_t world = 0; world < 50; ++world) {
      const double vy = results.values[4 * world + 1], mass = results.values[4 * world + 3], y = results.measures[world];
      failed += results.failures.count(world);
      CHECK((mass < 0) == (results.failures.count(world) == 1));
      CHECK(std::isnan(y) == (mass < 0));
      if (mass > 0) CHECK(y == doctest::Approx(vy - 5).epsilon(1e-9));
    }
    CHECK(failed == results.failures.size());
    CHECK(failed > 0);
  }
  const std::atomic<bool> stop = true;
  CHECK_FALSE(run(sweep, {.stop = &stop}).complete);
  CHECK_THROWS_AS((void)load(folder / "none.toml"), io::InputError);
}

TEST_CASE("blocks cover all worlds once; an exception ends them") {
  for (const int threads : {0, 1, 4})
    for (const std::uint64_t worlds : {0u, 1u, 7u, 1000u}) {
      std::vector<std::atomic<int>> seen(worlds);
      for_each_block(worlds, 8, threads, [&](std::uint64_t first, std::uint64_t count) {
        for (std::uint64_t i = first; i < first + count; ++i) ++seen[i];
      });
      for (const auto& each : seen) CHECK(each == 1);
    }
  CHECK_THROWS_AS(for_each_block(100, 1, 3,
                                 [](std::uint64_t first, std::uint64_t) {
                                   if (first == 40) throw std::runtime_error("forty");
                                 }),
                  std::runtime_error);
}
