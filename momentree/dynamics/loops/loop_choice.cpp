// Which rows of the loops' system are independent: a factorisation that takes large pivots first.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/loops/loop_system.hpp>

namespace momentree::detail {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Tries rows against the rows taken so far.
class Choice {
 public:
  explicit Choice(LoopWorkspace& loops) : loops_(loops), c_(loops.choice) {
    c_.taken.clear(), c_.begin.clear(), c_.start.clear(), c_.postponed.clear(), c_.F.clear();
    for (std::size_t i = 0; i < loops.rows.size(); ++i) c_.scale[i] = 1 / std::sqrt(loops.rows[i].scale);
  }

  int taken() const { return static_cast<int>(c_.taken.size()); }
  const LoopWorkspace& loops() const { return loops_; }
  RowChoice& memory() { return c_; }

  // Row i of the factor from column `begin` on, in trial memory k; its diagonal squared is returned, relative to the row's scale.
  double factor(int i, int begin, std::size_t k) {
    double* const x = trial(k);
    double rest = scaled(i, i);
    for (int j = begin; j < taken(); ++j) {
      const double* const L = row(j);
      double s = scaled(i, c_.taken[at(j)]);
      for (int l = std::max(begin, c_.begin[at(j)]); l < j; ++l) s -= x[l - begin] * L[l];
      x[j - begin] = s / L[j];
      rest -= x[j - begin] * x[j - begin];
    }
    return rest;
  }
  // Takes row i, whose row of the factor is in trial memory k.
  void take(int i, int begin, std::size_t k, double rest) {
    c_.begin.push_back(begin);
    c_.start.push_back(c_.F.size());
    const double* const x = trial(k);
    c_.F.insert(c_.F.end(), x, x + (taken() - begin));
    c_.F.push_back(std::sqrt(rest));
    c_.taken.push_back(i);
  }
  // Extends the row in trial memory k by the column of the row taken last.
  double extend(int i, int begin, std::size_t k) {
    const int j = taken() - 1;
    const double* const L = row(j);
    double* const x = trial(k);
    double s = scaled(i, c_.taken.back());
    for (int l = std::max(begin, c_.begin.back()); l < j; ++l) s -= x[l - begin] * L[l];
    x[j - begin] = s / L[j];
    return x[j - begin];
  }

 private:
  double* trial(std::size_t k) { return c_.trial.data() + k * loops_.rows.size(); }
  // Its element l is the factor's (j, l).
  const double* row(int j) const { return c_.F.data() + c_.start[at(j)] - c_.begin[at(j)]; }
  double scaled(int i, int j) const { return loops_.all.element(loops_.A, at(i), at(j)) * c_.scale[at(i)] * c_.scale[at(j)]; }
  LoopWorkspace& loops_;
  RowChoice& c_;
};

// Takes the rows [first, last) of one loop, largest pivots first, as long as these are large; postpones the others.
void choose_among(Choice& choice, int first, int last, int begin, double large, double tolerance) {
  RowChoice& c = choice.memory();
  const auto n = at(last - first);
  for (std::size_t k = 0; k < n; ++k) c.remainder[k] = choice.factor(first + static_cast<int>(k), begin, k);
  for (;;) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < n; ++k)
      if (c.remainder[k] > c.remainder[best]) best = k;
    if (n == 0 || !(c.remainder[best] > large)) break;
    choice.take(first + static_cast<int>(best), begin, best, c.remainder[best]);
    c.remainder[best] = -1;
    for (std::size_t k = 0; k < n; ++k) {
      if (c.remainder[k] < 0) continue;
      const double x = choice.extend(first + static_cast<int>(k), begin, k);
      c.remainder[k] -= x * x;
    }
  }
  for (std::size_t k = 0; k < n; ++k)
    if (c.remainder[k] > tolerance) c.postponed.push_back(first + static_cast<int>(k));
}

}  // namespace

// Small pivots come last, because round-off grows by what is divided by them: then a redundant row could seem independent. Rows
// are taken loop by loop, so that the factor has few elements; each further pass takes smaller pivots among those left over.
void choose_rows(const Tree& tree, LoopWorkspace& loops, double tolerance) noexcept {
  constexpr double large = 1e-3, next = 1e-3;
  Choice choice(loops);
  RowChoice& c = loops.choice;
  const std::span<const LoopLink> links = tree.loops().links;
  for (std::size_t l = 0; l < links.size(); ++l) {
    c.taken_before[l] = choice.taken();
    choose_among(choice, links[l].first_row, links[l].first_row + links[l].rows, c.taken_before[at(links[l].coupled)],
                 std::max(large, tolerance), tolerance);
  }
  for (double pivot = large * next; !c.postponed.empty(); pivot *= next) {
    std::size_t left = 0;
    for (const int i : c.postponed) {
      const auto loop =
          std::upper_bound(links.begin(), links.end(), i, [](int row, const LoopLink& link) { return row < link.first_row; });
      const int begin = c.taken_before[at(std::prev(loop)->coupled)];
      const double rest = choice.factor(i, begin, 0);
      if (rest > std::max(pivot, tolerance))
        choice.take(i, begin, 0, rest);
      else if (rest > tolerance)
        c.postponed[left++] = i;
    }
    c.postponed.resize(left);
    if (pivot <= tolerance) break;
  }
  std::sort(c.taken.begin(), c.taken.end());
  loops.rank = choice.taken();
  lay_out(tree, c.taken, loops.kept);
  for (std::size_t i = 0; i < c.taken.size(); ++i) c.mobility[i] = loops.all.element(loops.A, at(c.taken[i]), at(c.taken[i]));
  std::fill(loops.least_pivots.begin(), loops.least_pivots.end(), 0.0);
}

LaneChoice::LaneChoice() = default;
LaneChoice::~LaneChoice() = default;
void LaneChoice::fit(const Tree& tree) {
  if (one_.topology == tree.loops().revision()) return;
  lay_out_loops<double>(tree, one_);
  one_.choice.reserve(tree.loops().links.size(), one_.rows.size(), one_.all.elements);
  chosen_.resize(one_.rows.size());
  union_.reserve(one_.rows.size());
}
double* LaneChoice::A() noexcept { return one_.A.data(); }
void LaneChoice::set_scale(std::size_t row, double scale) noexcept { one_.rows[row].scale = scale; }
void LaneChoice::start() noexcept { std::fill(chosen_.begin(), chosen_.end(), 0u); }
void LaneChoice::choose_lane(const Tree& tree, int lane) noexcept {
  choose_rows(tree, one_, rank_tolerance);
  for (const int row : one_.kept.rows) chosen_[at(row)] |= 1u << lane;
}
void LaneChoice::keep(const Tree& tree, LoopLayout& kept) noexcept {
  union_.clear();
  for (std::size_t i = 0; i < chosen_.size(); ++i)
    if (chosen_[i] != 0) union_.push_back(static_cast<int>(i));
  lay_out(tree, union_, kept);
}
bool LaneChoice::chosen(int row, int lane) const noexcept { return (chosen_[at(row)] >> lane & 1u) != 0; }

void lay_out(const Tree& tree, const std::vector<int>& rows, LoopLayout& layout) {
  const std::span<const LoopLink> links = tree.loops().links;
  layout.rows = rows;
  layout.begin.resize(rows.size()), layout.position.resize(rows.size());
  layout.first_of.resize(links.size() + 1);
  layout.elements = 0;
  std::size_t i = 0;
  for (std::size_t l = 0; l < links.size(); ++l) {
    layout.first_of[l] = static_cast<int>(i);
    const int begin = layout.first_of[at(links[l].coupled)];
    for (; i < rows.size() && rows[i] < links[l].first_row + links[l].rows; ++i) {
      layout.begin[i] = begin;
      layout.position[i] = static_cast<std::ptrdiff_t>(layout.elements) - begin;
      layout.elements += i + 1 - at(begin);
    }
  }
  layout.first_of[links.size()] = static_cast<int>(i);
}

}  // namespace momentree::detail
