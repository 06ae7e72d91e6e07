#include <momentree/results/recording/body_table.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <momentree/base/error.hpp>

namespace momentree::io {
namespace {

constexpr const char* suffixes[7] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
constexpr std::size_t missing = std::numeric_limits<std::size_t>::max();

}  // namespace

BodyTable::BodyTable(const std::filesystem::path& file) : table_(file) {
  const std::string header = table_.header_place();
  std::map<std::string, std::size_t> number_of;
  for (std::size_t c = 0; c < table_.columns().size(); ++c) {
    const std::string& column = table_.columns()[c];
    const std::size_t dot = column.rfind('.');
    const auto which =
        std::find(std::begin(suffixes), std::end(suffixes), dot == std::string::npos ? "" : column.substr(dot + 1));
    if (which == std::end(suffixes))
      throw_error({"column '" + column + "' is not part of a pose", header, "expected <body>.x .y .z .qw .qx .qy .qz"});
    const auto [body, is_new] = number_of.try_emplace(column.substr(0, dot), bodies_.size());
    if (is_new) bodies_.push_back(body->first), at_.resize(7 * bodies_.size(), missing);
    std::size_t& at = at_[7 * body->second + static_cast<std::size_t>(which - std::begin(suffixes))];
    if (at != missing) throw_error({"column '" + column + "' occurs twice", header, {}});
    at = c;
  }
  for (std::size_t i = 0; i < at_.size(); ++i)
    if (at_[i] == missing)
      throw_error({"the column '" + bodies_[i / 7] + "." + suffixes[i % 7] + "' is missing", header,
                   "a body needs .x .y .z .qw .qx .qy .qz"});
  if (bodies_.empty()) throw_error({"it has no bodies", header, {}});
  if (times().empty()) throw_error({"it has no complete row", file.string(), "the run stopped before it wrote one"});
}

std::size_t BodyTable::row_near(double time) const {
  const std::vector<double>& times = table_.times();
  const double same = 1e-9 * std::max(1.0, std::abs(time));
  auto after = std::upper_bound(times.begin(), times.end(), time + same);
  if (after == times.begin()) return 0;
  const auto before = after - 1;
  if (after != times.end() && *after - time < time - *before) {
    const double next = *after;  // of several rows at that instant the last
    return static_cast<std::size_t>(std::upper_bound(after, times.end(), next) - times.begin()) - 1;
  }
  return static_cast<std::size_t>(before - times.begin());
}

std::vector<double> BodyTable::in_order(const std::vector<double>& cells) const {
  std::vector<double> poses;
  poses.reserve(cells.size());
  for (std::size_t row = 0; row < cells.size(); row += at_.size())
    for (const std::size_t at : at_) poses.push_back(cells[row + at]);
  return poses;
}

std::vector<RecordedFrame> BodyTable::read(const std::vector<std::size_t>& rows) const {
  const std::vector<double> numbers = poses(rows);
  std::vector<RecordedFrame> frames;
  const double* v = numbers.data();
  for (const std::size_t row : rows) {
    RecordedFrame frame{times()[row], {}};
    for (std::size_t b = 0; b < bodies_.size(); ++b, v += 7) {
      for (std::size_t k = 0; k < 7; ++k)
        if (!std::isfinite(v[k]))
          throw_error({"column '" + bodies_[b] + "." + suffixes[k] + "' is " + (std::isnan(v[k]) ? "nan" : "inf") +
                           ", not a finite number",
                       table_.place(row), "the run diverged here; try a smaller step"});
      if (v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6] < 1e-12)
        throw_error({"the quaternion of '" + bodies_[b] + "' is zero", table_.place(row), {}});
      frame.poses.emplace_back(Vec3{v[0], v[1], v[2]}, Quat{v[3], v[4], v[5], v[6]});
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::vector<std::size_t> choose_rows(const BodyTable& table, double& every) {
  const double first = table.times().front(), last = table.times().back(), span = last - first;
  if (every < 0 || !std::isfinite(every))
    throw_error({"the time between frames must be positive", "--every", "for example --every 0.2"});
  if (every == 0) {
    every = 0.2;  // as in the paper's Figure 3, if that gives neither too few nor too many frames
    for (double unit = 1e-9; unit < 1e9 && (span < 4 * every || span > 60 * every); unit *= 10)
      for (const double step : {1.0, 2.0, 5.0})
        if (span >= 12 * step * unit && span <= 32 * step * unit) every = step * unit;
  }
  if (span / every > 2000) throw_error({"that would be more than 2000 frames", "--every", "use a longer time between frames"});
  std::vector<std::size_t> rows;
  for (int k = 0; first + k * every <= last + 1e-9 * std::max(1.0, std::abs(last)); ++k) {
    const std::size_t row = table.row_near(first + k * every);
    if (rows.empty() || row > rows.back()) rows.push_back(row);
  }
  return rows;
}

}  // namespace momentree::io
