#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include <momentree/base/error.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/sweep/checksum.hpp>
#include <momentree/sweep/journal.hpp>
#include <momentree/sweep/machines/coordinator.hpp>
#include <momentree/sweep/machines/encoding.hpp>
#include <momentree/text/files/text_file.hpp>

using namespace momentree::sweep;

namespace {

struct Folder : momentree::io::test::TemporaryFolder {
  std::string file() const { return *this / "journal"; }
};

const JournalIdentity identity{"1.2.3", "0123456789abcdef", "fedcba9876543210", 100, 2};

// World w has the measures w and -w/3; every seventh one failed.
std::string worlds(Chunk chunk) {
  std::string bytes;
  for (std::uint64_t w = chunk.first; w < chunk.first + chunk.count; ++w) {
    WorldResult result{{static_cast<double>(w), -static_cast<double>(w) / 3}, {}};
    if (w % 7 == 0) result = {{}, "world " + std::to_string(w) + " failed"};
    encode(result, bytes);
  }
  return bytes;
}

void overwrite(const std::string& path, const std::string& bytes) { momentree::io::write_text_file(path, bytes); }

}  // namespace

TEST_CASE("the checksum is CRC-32C") {
  CHECK(crc32c("") == 0);
  CHECK(crc32c("123456789") == 0xe3069283u);
  CHECK(crc32c("6789", crc32c("12345")) == 0xe3069283u);
}

TEST_CASE("results are read as they were encoded") {
  const std::string bytes = worlds({5, 4});
  ResultReader reader(bytes, 2);
  WorldResult result;
  REQUIRE(reader.next(result));
  CHECK((result.done() && result.measures == std::vector<double>{5, -5.0 / 3}));
  REQUIRE((reader.next(result) && reader.next(result)));
  CHECK(result.failure == "world 7 failed");
  CHECK((result.measures.size() == 2 && std::isnan(result.measures[0])));
  REQUIRE(reader.next(result));
  CHECK((reader.at_end() && !reader.next(result)));
  CHECK(is_encoded(bytes, 2, 4));
  CHECK(!is_encoded(bytes, 2, 5));
  CHECK(!is_encoded(bytes, 3, 4));
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(!is_encoded(bytes.substr(0, size), 2, 4));
}

TEST_CASE("a journal cut off at any byte has all records that are complete") {
  const Folder folder;
  std::vector<std::size_t> ends;  // of the file after each record
  {
    Journal journal = Journal::create(folder.file(), identity);
    ends.push_back(journal.size());
    for (const Chunk chunk : {Chunk{0, 10}, {40, 3}, {10, 25}}) {
      journal.append(chunk, worlds(chunk));
      ends.push_back(journal.size());
    }
  }
  const std::string all = momentree::io::read_text_file(folder.file());
  REQUIRE(all.size() == ends.back());
  for (std::size_t size = 0; size <= all.size(); ++size) {
    overwrite(folder.file(), all.substr(0, size));
    if (size < ends.front()) {
      CHECK_THROWS_AS(Journal::open(folder.file()), momentree::Error);
      continue;
    }
    Journal journal = Journal::open(folder.file());
    std::size_t complete = 0;
    while (complete + 1 < ends.size() && ends[complete + 1] <= size) ++complete;
    REQUIRE(journal.entries().size() == complete);
    CHECK(journal.was_cut() == (size != ends[complete]));
    CHECK(journal.identity() == identity);
    journal.append({60, 2}, worlds({60, 2}));  // goes on
    const Journal again = Journal::open(folder.file());
    REQUIRE(again.entries().size() == complete + 1);
    CHECK(again.read(again.entries().back()) == worlds({60, 2}));
  }
}

TEST_CASE("a damaged journal never gives other results") {
  const Folder folder;
  std::vector<Chunk> chunks = {{0, 10}, {40, 3}, {10, 25}};
  {
    Journal journal = Journal::create(folder.file(), identity);
    for (const Chunk chunk : chunks) journal.append(chunk, worlds(chunk));
  }
  const std::string all = momentree::io::read_text_file(folder.file());
  for (std::size_t at = 0; at < all.size(); ++at) {
    std::string damaged = all;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    overwrite(folder.file(), damaged);
    try {
      const Journal journal = Journal::open(folder.file());
      REQUIRE(journal.identity() == identity);
      REQUIRE(journal.entries().size() == chunks.size() - 1);  // all others are kept
      CHECK((journal.was_cut() || journal.damage().records == 1));
      for (const Journal::Entry& entry : journal.entries()) CHECK(journal.read(entry) == worlds(entry.chunk));
    } catch (const momentree::Error& error) {
      CHECK(error.where == folder.file());
    }
  }
}

TEST_CASE("worlds of a damaged record are computed again, and the others are kept") {
  const Folder folder;
  std::vector<std::uint64_t> starts;
  {
    Journal journal = Journal::create(folder.file(), identity);
    for (const Chunk chunk : {Chunk{0, 10}, {40, 3}, {10, 25}}) {
      starts.push_back(journal.size());
      journal.append(chunk, worlds(chunk));
    }
  }
  std::string damaged = momentree::io::read_text_file(folder.file());
  for (const std::uint64_t start : starts) damaged[start + 40] = static_cast<char>(damaged[start + 40] ^ 1);  // in the results
  overwrite(folder.file(), damaged);
  {
    Journal journal = Journal::open(folder.file());
    CHECK((journal.entries().empty() && journal.damage().records == 3 && journal.damage().worlds == 38 && !journal.was_cut()));
    journal.append({0, 50}, worlds({0, 50}));
  }
  {
    const Journal journal = Journal::open(folder.file());
    REQUIRE(journal.entries().size() == 1);
    CHECK(journal.read(journal.entries().front()) == worlds({0, 50}));
    CHECK(journal.damage().records == 0);  // they were computed again
  }
  // Part of a record that could not be removed, for example on a full disk, between good ones.
  const std::string whole = momentree::io::read_text_file(folder.file());
  const std::string last = whole.substr(damaged.size());
  overwrite(folder.file(), damaged.substr(0, starts[0]) + damaged.substr(starts[0], 60) + last);
  const Journal journal = Journal::open(folder.file());
  REQUIRE(journal.entries().size() == 1);
  CHECK(journal.read(journal.entries().front()) == worlds({0, 50}));
}

TEST_CASE("a journal remembers what it belonged to") {
  const Folder folder;
  JournalIdentity other = identity;
  other.version = "1.2.4", other.hash = "another hash";
  {
    Journal journal = Journal::create(folder.file(), identity);
    journal.append({0, 10}, worlds({0, 10}));
    journal.accept(other);
    journal.append({10, 10}, worlds({10, 10}));
  }
  const Journal journal = Journal::open(folder.file());
  CHECK(journal.identity() == other);
  CHECK(journal.former() == std::vector<FormerIdentity>{{identity.version, identity.hash}});
  CHECK(journal.entries().size() == 2);
}

TEST_CASE("overlapping chunks are refused") {
  const Folder folder;
  {
    Journal journal = Journal::create(folder.file(), identity);
    journal.append({0, 10}, worlds({0, 10}));
    journal.append({9, 2}, worlds({9, 2}));
  }
  CHECK_THROWS_AS(Journal::open(folder.file()), momentree::Error);
}

TEST_CASE("the coordinator gives each missing world once, in chunks with results that come once") {
  const Folder folder;
  {
    Journal journal = Journal::create(folder.file(), identity);
    journal.append({3, 4}, worlds({3, 4}));
    journal.append({90, 10}, worlds({90, 10}));
  }
  Journal journal = Journal::open(folder.file());
  Coordinator work(journal, {.workers = 2});
  std::vector<int> given(100);
  std::optional<Chunk> lost;
  while (const std::optional<Chunk> chunk = work.next()) {
    for (std::uint64_t w = chunk->first; w < chunk->first + chunk->count; ++w) ++given.at(w);
    if (!lost) {
      lost = chunk;
      continue;
    }
    work.finished(*chunk, worlds(*chunk));
  }
  for (std::uint64_t w = 0; w < 100; ++w) CHECK(given[w] == ((w >= 3 && w < 7) || w >= 90 ? 0 : 1));
  CHECK(!work.complete());
  REQUIRE(lost);
  work.give_again(*lost);
  CHECK(work.next() == lost);
  work.finished(*lost, worlds(*lost));
  work.finished(*lost, worlds(*lost));  // of a slow worker
  work.give_again(*lost);
  CHECK(!work.next());
  CHECK(work.complete());
  CHECK(work.progress().done == 100);
  CHECK_THROWS_AS(work.finished({0, 2}, worlds({0, 3})), momentree::Error);
  std::vector<int> found(100);
  const Journal again = Journal::open(folder.file());
  for (const Journal::Entry& entry : again.entries())
    for (std::uint64_t w = entry.chunk.first; w < entry.chunk.first + entry.chunk.count; ++w) ++found.at(w);
  CHECK(found == std::vector<int>(100, 1));
}
