// The joints that form the tree of a model with loops.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/models/import/spanning.hpp>

using namespace momentree::io;

namespace {

struct Ends {
  int parent, child, rows;
};
std::vector<int> chosen(std::size_t links, const std::vector<Ends>& joints) {
  std::vector<SpanningEnds> all;
  for (std::size_t j = 0; j < joints.size(); ++j) all.push_back({joints[j].parent, joints[j].child, joints[j].rows, j});
  return spanning_joints(links, all);
}
/// True if every link leads to a root without a cycle, by joints whose child it is.
bool is_forest(const std::vector<Ends>& joints, const std::vector<int>& inboard) {
  for (std::size_t link = 0; link < inboard.size(); ++link) {
    int at = static_cast<int>(link);
    for (std::size_t steps = 0; at >= 0; ++steps) {
      const int joint = inboard[static_cast<std::size_t>(at)];
      if (steps > inboard.size() || (joint >= 0 && joints[static_cast<std::size_t>(joint)].child != at)) return false;
      at = joint < 0 ? -1 : joints[static_cast<std::size_t>(joint)].parent;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("spanning trees: a tree is left as it is") {
  CHECK(chosen(3, {{0, 1, 5}, {1, 2, 5}}) == std::vector<int>{-1, 0, 1});
  CHECK(chosen(2, {{-1, 0, 5}, {0, 1, 3}}) == std::vector<int>{0, 1});
}

TEST_CASE("spanning trees: a link keeps the joint with most rows, then that nearest to the root, then the first") {
  CHECK(chosen(3, {{0, 1, 5}, {0, 2, 3}, {1, 2, 5}}) == std::vector<int>{-1, 0, 2});
  CHECK(chosen(3, {{0, 1, 5}, {1, 2, 5}, {0, 2, 5}}) == std::vector<int>{-1, 0, 2});
  CHECK(chosen(3, {{0, 1, 5}, {1, 2, 5}, {-1, 2, 5}}) == std::vector<int>{-1, 0, 2});
  CHECK(chosen(2, {{0, 1, 5}, {0, 1, 5}}) == std::vector<int>{-1, 0});
}

TEST_CASE("spanning trees: a cycle is cut at its first link, or where another link leads to it") {
  CHECK(chosen(3, {{0, 1, 5}, {1, 2, 5}, {2, 0, 5}}) == std::vector<int>{-1, 0, 1});
  CHECK(chosen(4, {{3, 1, 3}, {0, 1, 5}, {1, 2, 5}, {2, 0, 5}}) == std::vector<int>{3, 0, 2, -1});
  CHECK(chosen(3, {{-1, 1, 3}, {0, 1, 5}, {1, 2, 5}, {2, 0, 5}}) == std::vector<int>{3, 0, 2});
  // A cycle that leads to another has the only root, even if it comes later.
  CHECK(chosen(4, {{0, 1, 5}, {1, 0, 5}, {2, 3, 5}, {3, 2, 5}, {3, 0, 5}}) == std::vector<int>{4, 0, -1, 2});
}

TEST_CASE("spanning trees: random graphs have as many roots as links that nothing leads to") {
  std::uint32_t seed = 1;
  const auto random = [&seed](int n) {
    seed = seed * 1664525u + 1013904223u;
    return static_cast<int>((seed >> 8) % static_cast<std::uint32_t>(n));
  };
  for (int sample = 0; sample < 2000; ++sample) {
    CAPTURE(sample);
    const int links = 1 + random(12), count = random(20);
    std::vector<Ends> joints;
    for (int j = 0; j < count; ++j) {
      const Ends ends{random(links + 1) - 1, random(links), 1 + random(6)};
      if (ends.parent != ends.child) joints.push_back(ends);
    }
    const std::vector<int> inboard = chosen(static_cast<std::size_t>(links), joints);
    REQUIRE(is_forest(joints, inboard));
    // By enumeration: links from which each link can be reached, and whether the ground is one.
    std::vector<std::vector<char>> reach(static_cast<std::size_t>(links) + 1,
                                         std::vector<char>(static_cast<std::size_t>(links), 0));
    for (int from = 0; from < links; ++from) reach[static_cast<std::size_t>(from)][static_cast<std::size_t>(from)] = 1;
    for (int round = 0; round <= links; ++round)
      for (std::size_t from = 0; from < reach.size(); ++from)
        for (const Ends& each : joints)
          if (each.parent < 0 ? from + 1 == reach.size() : reach[from][static_cast<std::size_t>(each.parent)])
            reach[from][static_cast<std::size_t>(each.child)] = 1;
    int roots = 0, needed = 0;
    for (int link = 0; link < links; ++link) {
      const auto at = static_cast<std::size_t>(link);
      roots += inboard[at] < 0;
      // One for each set of links that lead to each other and that nothing else leads to.
      bool source = !reach.back()[at];
      for (std::size_t other = 0; other < static_cast<std::size_t>(links); ++other)
        source = source && (!reach[other][at] || (reach[at][other] && other >= at));
      needed += source;
    }
    CHECK(roots == needed);
  }
}
