#include <momentree/io/picture/body_table.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include <momentree/base/error.hpp>
#include <momentree/io/line_reader.hpp>

namespace momentree::io {
namespace {

constexpr const char* suffixes[7] = {"x", "y", "z", "qw", "qx", "qy", "qz"};

std::string place(const std::filesystem::path& file, std::size_t line) { return file.string() + ":" + std::to_string(line); }

double number(const std::string& field, const std::string& column, const std::string& where) {
  double value = 0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (error != std::errc{} || stop != end)
    throw_error({"column '" + column + "': '" + field + "' is not a number", where,
                 "bodies.csv as written by `momentree run` is needed"});
  if (!std::isfinite(value))
    throw_error(
        {"column '" + column + "' is " + field + ", not a finite number", where, "the run diverged here; try a smaller step"});
  return value;
}

std::vector<PoseColumns> find_bodies(const std::vector<std::string>& columns, const std::string& where) {
  std::vector<PoseColumns> bodies;
  std::map<std::string, std::size_t> number_of;
  std::vector<unsigned> found;
  for (std::size_t c = 1; c < columns.size(); ++c) {
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

}  // namespace

std::vector<std::string> split_csv(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

BodyTable::BodyTable(std::filesystem::path file) : file_(std::move(file)) {
  if (!is_there(file_)) throw_error({"there is no such file", file_.string(), "give the directory that `momentree run` wrote"});
  LineReader in(file_);
  std::string line;
  if (!in.next(line)) throw_error({"the file is empty", file_.string(), {}});
  columns_ = split_csv(line);
  if (columns_.front() != "time")
    throw_error({"the first column is '" + columns_.front() + "', not 'time'", place(file_, 1), {}});
  bodies_ = find_bodies(columns_, place(file_, 1));
  while (in.next(line) && in.is_whole()) {  // otherwise an interrupted run was still writing this row
    if (line.empty()) continue;
    const double time = number(line.substr(0, line.find(',')), "time", place(file_, in.number()));
    if (!times_.empty() && time < times_.back()) throw_error({"time runs backwards", place(file_, in.number()), {}});
    times_.push_back(time);
  }
  if (times_.empty()) throw_error({"it has no complete row", file_.string(), "the run stopped before it wrote one"});
}

std::size_t BodyTable::row_near(double time) const {
  const double same = 1e-9 * std::max(1.0, std::abs(time));
  auto after = std::upper_bound(times_.begin(), times_.end(), time + same);
  if (after == times_.begin()) return 0;
  const auto before = after - 1;
  if (after != times_.end() && *after - time < time - *before) {
    const double next = *after;  // of several rows at that instant the last
    return static_cast<std::size_t>(std::upper_bound(after, times_.end(), next) - times_.begin()) - 1;
  }
  return static_cast<std::size_t>(before - times_.begin());
}

std::vector<RecordedFrame> BodyTable::read(const std::vector<std::size_t>& rows) const {
  std::vector<RecordedFrame> frames;
  LineReader in(file_);
  std::string line;
  in.next(line);
  std::size_t row = 0;
  for (const std::size_t wanted : rows) {
    while (row <= wanted && in.next(line))
      if (!line.empty()) ++row;
    const std::size_t n = in.number();
    const std::vector<std::string> fields = split_csv(line);
    if (fields.size() != columns_.size())
      throw_error({"the row has " + std::to_string(fields.size()) + " of " + std::to_string(columns_.size()) + " columns",
                   place(file_, n), "the file was truncated or modified: run again"});
    RecordedFrame frame{times_[wanted], {}};
    for (const PoseColumns& body : bodies_) {
      std::array<double, 7> v{};
      for (std::size_t k = 0; k < 7; ++k) v[k] = number(fields[body.at[k]], columns_[body.at[k]], place(file_, n));
      if (v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6] < 1e-12)
        throw_error({"the quaternion of '" + body.name + "' is zero", place(file_, n), {}});
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
