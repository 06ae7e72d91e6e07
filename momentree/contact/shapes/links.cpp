#include <momentree/contact/shapes/links.hpp>

#include <algorithm>
#include <utility>

namespace momentree::contact {

namespace {

std::size_t six_of(int link) { return 6 * static_cast<std::size_t>(link); }

// y += A x, and y += Aᵀ x, for a matrix of 6 × 6 by columns.
void add_product(const std::array<double, 36>& A, const double* x, double* y) {
  for (std::size_t c = 0; c < 6; ++c)
    for (std::size_t k = 0; k < 6; ++k) y[k] += A[6 * c + k] * x[c];
}
void add_transposed_product(const std::array<double, 36>& A, const double* x, double* y) {
  for (std::size_t c = 0; c < 6; ++c)
    for (std::size_t k = 0; k < 6; ++k) y[c] += A[6 * c + k] * x[k];
}

}  // namespace

void Links::clear(int links, int trees) {
  all.assign(static_cast<std::size_t>(links), {});
  first_.assign(static_cast<std::size_t>(trees), -1);
}

// The motion of a body by wrenches on it, in a tree that moves with it: E Mj⁻¹ Eᵀ + T Λ⁻¹ Tᵀ with that of its parent, Λ⁻¹
// (Featherstone 2008, 9.4). With it, and with what bodies carry to their parents, impulses are followed from point to point in a
// time that depends on the way between these alone.
void Links::find_whole(int first, int end) {
  first_[static_cast<std::size_t>(all[static_cast<std::size_t>(first)].group)] = first;
  for (int i = first; i < end; ++i) {
    Link& link = all[static_cast<std::size_t>(i)];
    link.whole = link.own;
    if (link.parent < 0) continue;
    for (std::size_t c = 0; c < 6; ++c) {
      double moved[6] = {};
      add_product(all[static_cast<std::size_t>(link.parent)].whole, link.carried.data() + 6 * c, moved);
      add_transposed_product(link.carried, moved, link.whole.data() + 6 * c);
    }
  }
}

void Links::start(LinksMotion& motion, int others) const {
  motion.x.assign(6 * all.size() + static_cast<std::size_t>(others), 0.0);
  motion.sum.assign(6 * all.size(), 0.0), motion.sent.assign(6 * all.size(), 0.0);
  motion.at.assign(first_.size(), -1);
}

void Links::forget(int tree, LinksMotion& motion) const {
  if (std::exchange(motion.at[static_cast<std::size_t>(tree)], -1) < 0) return;
  const int first = first_[static_cast<std::size_t>(tree)];
  int end = first;
  while (end < static_cast<int>(all.size()) && all[static_cast<std::size_t>(end)].group == tree) ++end;
  for (std::vector<double>* of : {&motion.x, &motion.sum, &motion.sent})
    std::fill(of->data() + six_of(first), of->data() + six_of(end), 0.0);
}

// From a link to its parent, which feels what the link got since it was reached from there.
void Links::up(LinksMotion& motion, int from) const {
  const Link& link = all[static_cast<std::size_t>(from)];
  double got[6], carried[6] = {};
  for (std::size_t k = 0; k < 6; ++k) {
    const std::size_t own = six_of(from) + k;
    got[k] = motion.sum[own] - std::exchange(motion.sent[own], motion.sum[own]);
  }
  add_product(link.carried, got, carried);
  for (std::size_t k = 0; k < 6; ++k) motion.sum[six_of(link.parent) + k] += carried[k];
  add_product(all[static_cast<std::size_t>(link.parent)].whole, carried, motion.x.data() + six_of(link.parent));
}

// From the parent of a link to it.
void Links::down(LinksMotion& motion, int to) const {
  const Link& link = all[static_cast<std::size_t>(to)];
  double x[6] = {};
  add_transposed_product(link.carried, motion.x.data() + six_of(link.parent), x);
  add_product(link.own, motion.sum.data() + six_of(to), x);
  std::copy_n(x, 6, motion.x.data() + six_of(to));
}

void Links::walk(LinksMotion& motion, int to) {
  const auto tree = static_cast<std::size_t>(all[static_cast<std::size_t>(to)].group);
  int& at = motion.at[tree];
  if (at < 0) at = first_[tree];
  way_.clear();
  const auto link = [&](int i) -> const Link& { return all[static_cast<std::size_t>(i)]; };
  for (int meet = to; at != meet;) {
    if (link(meet).depth >= link(at).depth)
      way_.push_back(meet), meet = link(meet).parent;
    else
      up(motion, at), at = link(at).parent;
  }
  for (; !way_.empty(); way_.pop_back()) down(motion, at = way_.back());
}

void Links::complete(LinksMotion& motion, int tree) const {
  int& at = motion.at[static_cast<std::size_t>(tree)];
  if (at < 0) return;
  const int first = first_[static_cast<std::size_t>(tree)];
  for (; at != first; at = all[static_cast<std::size_t>(at)].parent) up(motion, at);
  for (int i = first + 1; i < static_cast<int>(all.size()) && all[static_cast<std::size_t>(i)].group == tree; ++i)
    down(motion, i);
}

}  // namespace momentree::contact
