#include <momentree/tree/state.hpp>

#include <algorithm>

#include <momentree/joint/dispatch.hpp>

namespace momentree {

State::State(const Tree& tree) : topology_(tree.revision()) {
  const auto n = static_cast<std::size_t>(tree.bodies());
  q_.reserve(7 * n);
  p_.reserve(6 * n);
  q_.resize(static_cast<std::size_t>(tree.nq()));
  p_.resize(static_cast<std::size_t>(tree.nv()));
  for (int b : tree.order())
    dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::zero(q_.data() + tree.first_q(b)); });
}

State& State::operator=(const State& other) {
  if (this == &other) return *this;
  time_ = other.time_;
  q_.reserve(other.q_.capacity());  // a copy can change its topology without allocating, too
  p_.reserve(other.p_.capacity());
  q_ = other.q_;
  p_ = other.p_;
  topology_ = other.topology_;
  ++serial_;
  return *this;
}

void State::assign(double time, std::span<const double> q, std::span<const double> p, std::uint64_t topology) {
  time_ = time;
  q_.assign(q.begin(), q.end());
  p_.assign(p.begin(), p.end());
  topology_ = topology;
  ++serial_;
}

namespace {
void replace_range(std::vector<double>& all, int first, int count, std::span<const double> with) {
  const auto growth = static_cast<std::ptrdiff_t>(with.size()) - count;
  if (growth > 0 && all.capacity() < all.size() + static_cast<std::size_t>(growth))  // a body was added
    all.reserve(2 * all.capacity() + with.size());
  const auto tail = all.begin() + first + count;
  if (growth > 0) {
    const auto old_size = static_cast<std::ptrdiff_t>(all.size());
    all.resize(all.size() + static_cast<std::size_t>(growth));  // within the reserved capacity: iterators stay
    std::move_backward(tail, all.begin() + old_size, all.end());
  } else if (growth < 0) {
    std::move(tail, all.end(), tail + growth);
    all.resize(all.size() - static_cast<std::size_t>(-growth));
  }
  std::copy(with.begin(), with.end(), all.begin() + first);
}
}  // namespace

void State::replace(int first_q, int nq, std::span<const double> q, int first_p, int nv, std::span<const double> p,
                    std::uint64_t topology) {
  replace_range(q_, first_q, nq, q);
  replace_range(p_, first_p, nv, p);
  topology_ = topology;
  ++serial_;
}

}  // namespace momentree
