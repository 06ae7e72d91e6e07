#include <momentree/io/picture/body_table.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include <momentree/base/error.hpp>

namespace momentree::io {
namespace {

constexpr const char* suffixes[7] = {"x", "y", "z", "qw", "qx", "qy", "qz"};

}  // namespace

std::vector<PoseColumns> find_bodies(const NumberTable& table) {
  const std::vector<std::string>& columns = table.columns();
  const std::string where = table.place();
  std::vector<PoseColumns> bodies;
  std::map<std::string, std::size_t> number_of;
  std::vector<unsigned> found;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::size_t dot = columns[c].rfind('.');
    const std::string suffix = dot == std::string::npos ? "" : columns[c].substr(dot + 1);
    const auto which = std::find(std::begin(suffixes), std::end(suffixes), suffix);
    if (which == std::end(suffixes))
      throw_error({"column '" + columns[c] + "' is not part of a pose", where, "expected <body>.x .y .z .qw .qx .qy .qz"});
    const std::string name = columns[c].substr(0, dot);
    const auto [body, is_new] = number_of.try_emplace(name, bodies.size());
    if (is_new) bodies.push_back({name, {}}), found.push_back(0);
    const auto k = static_cast<std::size_t>(which - std::begin(suffixes));
    if (found[body->second] & (1U << k)) throw_error({"column '" + columns[c] + "' occurs twice", where, {}});
    found[body->second] |= 1U << k;
    bodies[body->second].at[k] = c;
  }
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (std::size_t k = 0; k < 7; ++k)
      if (!(found[b] & (1U << k)))
        throw_error({"the column '" + bodies[b].name + "." + suffixes[k] + "' is missing", where,
                     "a body needs .x .y .z .qw .qx .qy .qz"});
  if (bodies.empty()) throw_error({"it has no bodies", where, {}});
  return bodies;
}

BodyTable::BodyTable(const std::filesystem::path& file) : NumberTable(file), bodies_(find_bodies(*this)) {
  if (times().empty()) throw_error({"it has no complete row", file.string(), "the run stopped before it wrote one"});
}

std::size_t BodyTable::row_near(double time) const {
  const double same = 1e-9 * std::max(1.0, std::abs(time));
  auto after = std::upper_bound(times().begin(), times().end(), time + same);
  if (after == times().begin()) return 0;
  const auto before = after - 1;
  if (after != times().end() && *after - time < time - *before) {
    const double next = *after;  // of several rows at that instant the last
    return static_cast<std::size_t>(std::upper_bound(after, times().end(), next) - times().begin()) - 1;
  }
  return static_cast<std::size_t>(before - times().begin());
}

std::vector<RecordedFrame> BodyTable::frames(const std::vector<std::size_t>& rows) const {
  const std::vector<double> numbers = read(rows, Gaps::refused);
  std::vector<RecordedFrame> frames;
  const double* first = numbers.data();
  for (const std::size_t row : rows) {
    RecordedFrame frame{times()[row], {}};
    for (const PoseColumns& body : bodies_) {
      const auto v = [&](std::size_t k) { return first[body.at[k]]; };
      const Quat q{v(3), v(4), v(5), v(6)};
      if (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z < 1e-12)
        throw_error({"the quaternion of '" + body.name + "' is zero", place(row), {}});
      frame.poses.emplace_back(Vec3{v(0), v(1), v(2)}, q);
    }
    frames.push_back(std::move(frame));
    first += columns().size();
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
