// Sparse elimination by blocks, against dense equations.
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/block_elimination.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using contact::BlockElimination;

TEST_CASE("block elimination: solutions obey the equations, whatever blocks are connected") {
  oracle::Prng random(4);
  for (int k = 0; k < 300; ++k) {
    std::vector<int> sizes(static_cast<std::size_t>(1 + k % 12));
    for (int& size : sizes) size = 1 + static_cast<int>(random.uniform(0, 8));
    BlockElimination matrix;
    matrix.clear(sizes);
    std::vector<std::pair<int, int>> blocks;
    for (int i = 0; i < static_cast<int>(sizes.size()); ++i)
      for (int j = 0; j <= i; ++j)
        if (i == j || random.uniform(0, 1) < 0.4) matrix.connect(i, j), blocks.emplace_back(i, j), blocks.emplace_back(j, i);
    matrix.analyse();
    matrix.reset();
    const std::size_t n = matrix.unknowns();
    std::vector<double> dense(n * n, 0.0), right(n), x, product(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) dense[i * n + i] = 1;
    for (const auto& [one, other] : blocks)
      for (std::size_t i = 0; i < static_cast<std::size_t>(sizes[static_cast<std::size_t>(one)]); ++i)
        for (std::size_t j = 0; j < static_cast<std::size_t>(sizes[static_cast<std::size_t>(other)]); ++j) {
          const double value = random.uniform(-0.1, 0.1);
          matrix.block(one, other)[i * static_cast<std::size_t>(sizes[static_cast<std::size_t>(other)]) + j] += value;
          dense[(matrix.first(one) + i) * n + matrix.first(other) + j] += value;
        }
    for (double& value : right) value = random.uniform(-1, 1);
    x = right;
    REQUIRE(matrix.factorise());
    matrix.solve(x.data());
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) product[i] += dense[i * n + j] * x[j];
    for (std::size_t i = 0; i < n; ++i) CHECK(std::fabs(product[i] - right[i]) < 1e-10);
  }
}
