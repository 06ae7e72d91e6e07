#include <momentree/tree/state.hpp>

#include <algorithm>
#include <utility>

#include <momentree/base/unique_number.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

State::State() : number_(detail::unique_number()) {}

State::State(const Tree& tree, Variables variables)
    : variables_(variables), number_(detail::unique_number()), topology_(tree.revision()) {
  const auto n = static_cast<std::size_t>(tree.bodies());
  q_.reserve(7 * n);
  y_.reserve(6 * n);
  q_.resize(static_cast<std::size_t>(tree.nq()));
  y_.resize(static_cast<std::size_t>(tree.nv()));
  for (int b : tree.order())
    dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::zero(q_.data() + tree.first_q(b)); });
}

State::State(const State& other) : number_(detail::unique_number()) { *this = other; }

State::State(State&& other) noexcept : number_(detail::unique_number()) { *this = std::move(other); }

void State::require_no_edit() const { MT_REQUIRE(!being_edited(), "the state's Edit has ended: close its scope first"); }

State& State::operator=(const State& other) {
  require_no_edit();
  if (this == &other) return *this;
  changed();  // first, because the copy may run out of memory
  time_ = other.time_;
  q_.reserve(other.q_.capacity());  // so that a copy can change its topology without allocating, too
  y_.reserve(other.y_.capacity());
  q_ = other.q_;
  y_ = other.y_;
  turns_ = other.turns_;
  variables_ = other.variables_;
  topology_ = other.topology_;
  return *this;
}

// Exchanges both states, with their stamps.
State& State::operator=(State&& other) noexcept {
  require_no_edit();
  other.require_no_edit();
  std::swap(time_, other.time_);
  q_.swap(other.q_);
  y_.swap(other.y_);
  turns_.swap(other.turns_);
  std::swap(variables_, other.variables_);
  std::swap(number_, other.number_);
  std::swap(serial_, other.serial_);
  std::swap(topology_, other.topology_);
  return *this;
}

void State::assign(double time, std::span<const double> q, std::span<const double> y, const Tree& tree) {
  require_no_edit();
  MT_REQUIRE(static_cast<int>(q.size()) == tree.nq() && static_cast<int>(y.size()) == tree.nv(),
             "as many coordinates and momenta as the tree has");
  changed();
  time_ = time;
  q_.assign(q.begin(), q.end());
  y_.assign(y.begin(), y.end());
  topology_ = tree.revision();
}

void State::set_turns(std::span<const Turns> turns) {
  changed();
  turns_.assign(turns.begin(), turns.end());
}

void State::set_turns(std::size_t place, const Turns& turns) {
  changed();
  if (place >= turns_.size()) turns_.resize(place + 1);
  turns_[place] = turns;
}

void State::remove_turns(std::size_t place) {
  changed();
  if (place < turns_.size()) turns_.erase(turns_.begin() + static_cast<std::ptrdiff_t>(place));
}

void State::change_variables(Variables variables, std::span<const double> y) {
  require_no_edit();
  MT_REQUIRE(y.size() == y_.size(), "as many numbers as the state has momenta or velocities");
  changed();
  variables_ = variables;
  std::copy(y.begin(), y.end(), y_.begin());
}

namespace {
void replace_range(std::vector<double>& all, int first, int count, std::span<const double> with) {
  const auto growth = static_cast<std::ptrdiff_t>(with.size()) - count;
  if (growth > 0 && all.capacity() < all.size() + static_cast<std::size_t>(growth))  // a body was added
    all.reserve(2 * all.capacity() + with.size());
  const auto tail = all.begin() + first + count;
  if (growth > 0) {
    const auto old_size = static_cast<std::ptrdiff_t>(all.size());
    all.resize(all.size() + static_cast<std::size_t>(growth));  // within the reserved capacity: iterators stay valid
    std::move_backward(tail, all.begin() + old_size, all.end());
  } else if (growth < 0) {
    std::move(tail, all.end(), tail + growth);
    all.resize(all.size() - static_cast<std::size_t>(-growth));
  }
  std::copy(with.begin(), with.end(), all.begin() + first);
}

// True if there are `count` numbers from `first` on whose replacement by `more` numbers gives a total of `sum`.
bool fits(const std::vector<double>& all, int first, int count, std::size_t more, int sum) {
  const auto size = static_cast<int>(all.size());
  return first >= 0 && count >= 0 && first <= size && count <= size - first && size - count + static_cast<int>(more) == sum;
}
}  // namespace

void State::replace(int first_q, int nq, std::span<const double> q, int first_p, int nv, std::span<const double> y,
                    const Tree& tree) {
  require_no_edit();
  MT_REQUIRE(fits(q_, first_q, nq, q.size(), tree.nq()) && fits(y_, first_p, nv, y.size(), tree.nv()),
             "as many coordinates and momenta as the tree will have");
  changed();
  replace_range(q_, first_q, nq, q);
  replace_range(y_, first_p, nv, y);
  topology_ = tree.revision();
}

}  // namespace momentree
