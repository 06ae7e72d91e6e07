// Incrementally updated tables must equal those of a newly built tree.
#include <algorithm>
#include <cstring>

#include <doctest/doctest.h>

#include <momentree/tree/edit.hpp>
#include <momentree/tree/unchecked_tree.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

bool same_bits(const double* a, const double* b, std::size_t count) { return std::memcmp(a, b, count * sizeof(double)) == 0; }

bool same_link(const Tree& a, const Tree& b, int body) {
  const auto &x = a.link(body), &y = b.link(body);
  const KernelFrame &f = a.frame(body), &g = b.frame(body);
  return same_bits(&x.cos_a, &y.cos_a, 6) && same_bits(&x.r.x, &y.r.x, 3) && same_bits(&x.body.m, &y.body.m, 1) &&
         same_bits(&x.body.mc.x, &y.body.mc.x, 3) && same_bits(&x.body.J.xx, &y.body.J.xx, 6) &&
         a.subtree_mass(body) == b.subtree_mass(body) && same_bits(&x.angle_0, &y.angle_0, 1) && x.locked == y.locked &&
         x.driven == y.driven && x.shape == y.shape && same_bits(&f.R.xx, &g.R.xx, 9) && same_bits(&f.r.x, &g.r.x, 3);
}

template <class A, class B>
bool same_list(const A& a, const B& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

// Compares all public data of a tree.
void check_same(const Tree& a, const Tree& b) {
  REQUIRE(a.bodies() == b.bodies());
  CHECK(a.nq() == b.nq());
  CHECK(a.nv() == b.nv());
  CHECK(a.first_root() == b.first_root());
  CHECK(a.tables().record_scalars == b.tables().record_scalars);
  CHECK(a.tables().has_forces == b.tables().has_forces);
  REQUIRE(same_list(a.order(), b.order()));
  CHECK(same_list(a.joints_with().quaternions, b.joints_with().quaternions));
  CHECK(same_list(a.joints_with().springs, b.joints_with().springs));
  CHECK(same_list(a.tables().angle_q, b.tables().angle_q));
  CHECK(same_list(a.tables().angle_offset, b.tables().angle_offset));
  const auto nv = static_cast<std::size_t>(a.nv());
  CHECK(same_bits(a.tables().armature.data(), b.tables().armature.data(), nv));
  CHECK(same_bits(a.tables().damping.data(), b.tables().damping.data(), nv));
  CHECK(same_bits(a.tables().effort.data(), b.tables().effort.data(), nv));
  REQUIRE(a.tables().runs.size() == b.tables().runs.size());
  for (std::size_t i = 0; i < a.tables().runs.size(); ++i) {
    const KernelRun &s = a.tables().runs[i], &t = b.tables().runs[i];
    CHECK((s.begin == t.begin && s.end == t.end && s.kind == t.kind && s.variant == t.variant && s.planar == t.planar));
  }
  CHECK(std::equal(a.tables().node_flags.begin(), a.tables().node_flags.end(), b.tables().node_flags.begin(),
                   b.tables().node_flags.end()));
  for (int k : a.order()) {
    INFO("body ", k);
    CHECK(a.parent(k) == b.parent(k));
    CHECK(a.first_child(k) == b.first_child(k));
    CHECK(a.next_sibling(k) == b.next_sibling(k));
    CHECK(a.first_q(k) == b.first_q(k));
    CHECK(a.first_p(k) == b.first_p(k));
    CHECK(UncheckedTree(a).first_angle(k) == UncheckedTree(b).first_angle(k));
    CHECK(UncheckedTree(a).record(k) == UncheckedTree(b).record(k));
    CHECK(a.joint_of(k) == b.joint_of(k));
    CHECK(b.carrier(a.joint_of(k)) == k);
    CHECK(a.reversed(k) == b.reversed(k));
    CHECK(a.variant(k) == b.variant(k));
    CHECK(same_link(a, b, k));
  }
}

}  // namespace

TEST_CASE("after every change the tables are those of a full rebuild") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomTreeOptions options;
    options.max_bodies = seed % 3 == 0 ? 60 : 15;
    options.all_free = seed % 2 == 0;
    Machine m(random_tree(seed, options).model);
    const Model start = m.model;
    Prng random(seed * 31 + 7);
    for (int k = 0; k < 80; ++k) {
      INFO("seed ", seed, " change ", k);
      act(random, m);
      Tree anew(start);
      if (k % 2 == 0) anew.edit().detach(start.size() - 1);  // it differs from the model there; the rest may be shared with it
      anew.edit().restore(m.tree.topology());
      check_same(m.tree, anew);
      if (k % 5 == 0) m.tree = Tree(m.tree);  // continues with a copy whose original no longer exists
      if (k % 7 == 0) {                       // and with an object that was another tree before
        Tree other(start);
        if (other.joint(0).kind != Kind::free) other.edit().detach(0);
        other = m.tree;
        m.tree = std::move(other);
        check_same(m.tree, anew);
      }
    }
  }
}
