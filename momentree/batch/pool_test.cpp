#include <momentree/batch/pool.hpp>

#include <atomic>
#include <vector>

#include <doctest/doctest.h>

using namespace momentree;

TEST_CASE("every task of a pool is done once, round after round, whatever the number of threads") {
  for (const int threads : {1, 2, 5}) {
    batch::Pool pool(threads);
    CHECK(pool.threads() == threads);
    for (int round = 0; round < 200; ++round) {
      const int count = round % 17;
      std::vector<int> done(static_cast<std::size_t>(count));
      std::atomic<bool> fits{true};
      pool.run(count, [&](int thread, int i) {
        ++done[static_cast<std::size_t>(i)];
        if (thread < 0 || thread >= threads) fits = false;
      });
      CHECK(fits);
      for (const int times : done) CHECK(times == 1);
    }
  }
}
