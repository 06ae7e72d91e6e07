// Which branches are paired: isomorphic ones on the same body or on the ground.
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

using namespace momentree;

namespace {

/// Adds a limb, with one letter per joint: r revolute, m revolute with armature, w weld, p prismatic. All placements differ.
BodyId limb(Model& model, BodyId last, const char* joints) {
  for (; *joints != '\0'; ++joints) {
    const double k = model.size() + 1;
    JointSpec joint = Revolute{.axis = {0.1 * k, 1, 0}};
    if (*joints == 'm') joint = Revolute{.axis = {0.1 * k, 1, 0}, .armature = 0.1 * k};
    if (*joints == 'w') joint = Weld{};
    if (*joints == 'p') joint = Prismatic{};
    const std::string name = std::to_string(model.size());
    last = model.add({.name = name, .mass = k, .inertia = diagonal(k), .parent = last, .at = {0.1 * k, 0.2, 0}, .joint = joint});
  }
  return last;
}
BodyId trunk(Model& model) { return model.add({.name = "trunk", .mass = 1, .inertia = diagonal(1), .joint = Free{}}); }

/// The pairs of a tree by the numbers of the bodies with which the branches begin, "first-other …".
std::string pairs(const Tree& tree) {
  std::string all;
  for (const KernelRun& s : tree.paired_runs())
    if (s.branch && s.pair > s.begin)
      all += (all.empty() ? "" : " ") + std::to_string(tree.order()[static_cast<std::size_t>(s.begin)]) + "-" +
             std::to_string(tree.order()[static_cast<std::size_t>(s.pair)]);
  return all;
}

/// Checks that the pieces cover the order in sequence, that pairs agree in length and kind, and that the constants are those of
/// both links.
void check_pieces(const Tree& tree) {
  int place = 0;
  for (const KernelRun& s : tree.paired_runs()) {
    CHECK(s.begin == place);
    place = s.end;
    if (s.pair < 0) continue;
    const KernelRun other = pair_of(s);
    bool found = false;
    for (const KernelRun& t : tree.paired_runs())
      if (t.begin == other.begin)
        found = t.end == other.end && t.kind == s.kind && t.pair == s.begin && t.branch == s.branch && t.links == s.links;
    CHECK(found);
    for (int i = 0; i < s.end - s.begin && s.begin < s.pair; ++i) {
      const LinkConstants& a = tree.link(tree.order()[static_cast<std::size_t>(s.begin + i)]);
      const LinkConstants& b = tree.link(tree.order()[static_cast<std::size_t>(s.pair + i)]);
      const PairedLinks& both = tree.paired_links()[static_cast<std::size_t>(s.links + i)];
      CHECK(both.body.m[0] == a.body.m);
      CHECK(both.body.m[1] == b.body.m);
      CHECK(both.cos_a[0] == a.cos_a);
      CHECK(both.r.x[1] == b.r.x);
    }
  }
  CHECK(place == static_cast<int>(tree.order().size()));
}

}  // namespace

TEST_CASE("isomorphic branches are paired, whatever is attached between them; others are not") {
  Model model;
  const BodyId base = trunk(model);                  // 0
  limb(model, base, "rrrr");                         // 1 … 4
  limb(model, base, "rrr");                          // 5 … 7: shorter
  limb(model, base, "rrwr");                         // with a weld
  limb(model, base, "rrrr");                         // 12 … 15, paired with 1
  limb(model, base, "rrpr");                         // 16 … 19: prismatic joints have no paired steps
  limb(model, base, "rrpr");                         // 20 … 23
  limb(model, base, "rrwr");                         // 24 … 27, paired with 8
  limb(model, base, "rrrr");                         // 28 … 31: a third
  limb(model, base, "rr"), limb(model, base, "rr");  // too short to gain
  limb(model, limb(model, base, "rrr"), "r");        // 36 … 39, paired with 28
  limb(model, base, "rmmr");                         // 40 … 43: with armature
  limb(model, base, "rrrr");                         // 44 … 47
  limb(model, base, "rmmr");                         // 48 … 51, paired with 40
  const Tree tree(model);
  CHECK(pairs(tree) == "1-12 8-24 28-36 40-48");
  check_pieces(tree);
}

TEST_CASE("branches that branch differently are not paired; pairs are not nested") {
  Model model;
  const BodyId base = trunk(model);  // 0
  for (int k = 0; k < 2; ++k) {      // 1 … 7, 8 … 14: a hand of two fingers
    const BodyId hand = limb(model, base, "r");
    limb(model, hand, "rrr"), limb(model, hand, "rrr");
  }
  const BodyId elsewhere = limb(model, base, "r");  // 15 … 21: the same number of bodies
  limb(model, elsewhere, "rrrr"), limb(model, elsewhere, "rr");
  const Tree tree(model);
  CHECK(pairs(tree) == "1-8");
  check_pieces(tree);
}

TEST_CASE("isomorphic mechanisms are paired, except planar ones, which have faster kernels") {
  Model model;
  const auto plane = [&model] {
    BodyId last = ground;
    for (int i = 0; i < 3; ++i)
      last = model.add({.name = "plane" + std::to_string(model.size()),
                        .mass = 1,
                        .inertia = diagonal(1),
                        .parent = last,
                        .at = {0.5, 0, 0},
                        .joint = Revolute{}});
  };
  plane();  // 0 … 2
  limb(model, ground, "rrr"), limb(model, ground, "rrrr"), limb(model, ground, "rrr");
  plane(), plane();
  const Tree tree(model);
  CHECK(pairs(tree) == "3-10");
  check_pieces(tree);
}

TEST_CASE("a pair is dissolved when one of its branches changes, and formed again when it is restored") {
  Model model;
  const BodyId base = trunk(model);
  limb(model, base, "rrrr"), limb(model, base, "rrrr"), limb(model, base, "rrrr");  // 1, 5, 9
  Tree tree(model);
  const Topology before = tree.topology();
  CHECK(pairs(tree) == "1-5");
  tree.detach(3);  // within branch 1
  CHECK(pairs(tree) == "5-9");
  check_pieces(tree);
  Joint locked = tree.joint(6);
  locked.locked = 1;
  tree.set_joint(6, locked);
  CHECK(pairs(tree).empty());
  CHECK(tree.paired_runs().size() == tree.kernel_runs().size());
  const Tree copy = tree;
  CHECK(pairs(copy).empty());
  tree.restore(before);
  CHECK(pairs(tree) == "1-5");
  check_pieces(tree);
  check_pieces(Tree(tree));
}
