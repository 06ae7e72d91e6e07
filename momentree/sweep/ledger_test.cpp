#include <momentree/sweep/ledger.hpp>

#include <doctest/doctest.h>

using namespace momentree::sweep;
using namespace std::chrono_literals;

TEST_CASE("a chunk that waits is moved to an idle rank: the last one of the longest queue") {
  Ledger ledger(3);
  for (int rank = 0; rank < 3; ++rank) ledger.join(rank, 1);
  const Ledger::Time start{};
  for (std::uint64_t i = 0; i < 3; ++i) ledger.give(1, {i, 1}, start);
  ledger.give(2, {3, 1}, start);
  const auto again = ledger.overdue(0, start);
  REQUIRE(again);
  CHECK(again->chunk == Chunk{2, 1});
  CHECK(again->from == 1);
  ledger.give(0, again->chunk, start);
  CHECK(ledger.held(1) == 2);
  CHECK(ledger.finish(0, {2, 1}, 1, start) == std::vector<int>{});
}

TEST_CASE("a running chunk is given again after twice the usual time, and after four times to a third rank") {
  Ledger ledger(4);
  for (int rank = 0; rank < 4; ++rank) ledger.join(rank, 1);
  const Ledger::Time start{};
  ledger.give(0, {0, 2}, start);
  ledger.give(1, {2, 4}, start);
  CHECK(ledger.finish(0, {0, 2}, 1, start + 1s).empty());  // 0.5 s for each item: 2 s for four
  CHECK(!ledger.overdue(0, start + 3900ms));
  const auto again = ledger.overdue(0, start + 4100ms);
  REQUIRE(again);
  CHECK(again->chunk == Chunk{2, 4});
  CHECK(!again->from);
  ledger.give(0, again->chunk, start + 4100ms);
  CHECK(!ledger.overdue(0, start + 100s));  // it has it
  CHECK(!ledger.overdue(2, start + 7900ms));
  CHECK(ledger.overdue(2, start + 8100ms));
  CHECK(ledger.finish(1, {2, 4}, 2, start + 9s) == std::vector<int>{0});
  CHECK(ledger.held(0) == 0);
  CHECK(!ledger.overdue(2, start + 100s));
}

TEST_CASE("a chunk runs from when its rank is free for it") {
  Ledger ledger(2);
  ledger.join(0, 1);
  ledger.join(1, 1);
  const Ledger::Time start{};
  ledger.give(1, {0, 1}, start);
  ledger.give(1, {1, 1}, start);
  ledger.finish(1, {0, 1}, 10, start + 10s);
  CHECK(!ledger.overdue(0, start + 29s));
  CHECK(ledger.overdue(0, start + 31s));
}
