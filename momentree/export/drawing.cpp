#include <momentree/export/drawing.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/export/solids.hpp>
#include <momentree/text/colour.hpp>

namespace momentree::io {

namespace {

constexpr const char* spring_bar_colour = "#6b7684";

/// The status that the run left: a run that was killed may have left none.
std::string status_in(const std::filesystem::path& file) {
  const std::optional<Value> summary = find_document(file);
  const Value::Entry* const status = summary ? summary->find("status") : nullptr;
  return status && status->value.string() ? *status->value.string() : "";
}

/// Reads the rows; unit quaternions, each with the sign that is nearer to that of the row before.
void read_rows(const BodyTable& table, const std::string& file, Drawing& drawing) {
  const std::size_t width = 7 * table.bodies().size();
  std::vector<double>& poses = drawing.poses = table.poses();
  const auto infinite = std::find_if(poses.begin(), poses.end(), [](double x) { return !std::isfinite(x); });
  const std::size_t count = static_cast<std::size_t>(infinite - poses.begin()) / width;
  if (count == 0) throw_error({"its first row has no finite poses", file, ""});
  poses.resize(count * width);
  drawing.times.assign(table.times().begin(), table.times().begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < poses.size(); i += 7) {
    double* const q = poses.data() + i + 3;
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6))
      throw_error(
          {"the quaternion of '" + table.bodies()[i % width / 7] + "' is zero", file, "the file was modified: run again"});
    const double* const before = i >= width ? q - width : q;
    const bool turn = before[0] * q[0] + before[1] * q[1] + before[2] * q[2] + before[3] * q[3] < 0;
    // Those that are of length one to round-off keep their bits.
    const double scale = (turn ? -1 : 1) * (std::abs(length - 1) < 1e-12 ? 1.0 : 1 / length);
    for (int k = 0; k < 4; ++k) q[k] *= scale;
  }
}

/// The phases that differ, without those that end where they begin; the first from the start of the run on.
std::vector<Colouring> colourings_of(const Recording& run, double start) {
  std::vector<Colouring> all;
  for (const Phase& phase : run.phases) {
    const double from = all.empty() ? start : phase.from;
    if (!all.empty() && all.back().mechanism == phase.mechanism) continue;
    if (!all.empty() && from <= all.back().from)
      all.back().mechanism = phase.mechanism;
    else
      all.push_back({from, phase.mechanism});
  }
  return all;
}

/// The bars of a joint that was made in the run: from what is drawn of its bodies to the joint; a weld is a strut between the
/// centres of mass.
std::vector<Bar> bars_of(const RecordedLoop& loop, const Recording& run) {
  const auto body = [&run](int number) -> const RecordedBody& { return run.bodies[static_cast<std::size_t>(number)]; };
  if (loop.kind == "weld" && loop.parent >= 0)
    return {{loop.name, loop.parent, loop.child, body(loop.parent).com, body(loop.child).com}};
  std::vector<Bar> bars;
  const auto reach = [&](int number, const Vec3& point) {
    const Vec3 from = nearest_on(body(number), point, body(number).com);
    if (norm(from - point) > 1e-9) bars.push_back({loop.name, number, number, from, point});
  };
  reach(loop.child, loop.child_at);
  if (loop.parent >= 0) reach(loop.parent, loop.at);
  return bars;
}

void add_bars(Drawing& drawing, double radius) {
  const Recording& run = drawing.run;
  for (const RecordedSpring& spring : run.springs)
    if (spring.until > drawing.times.front())
      drawing.bars.push_back({spring.name, spring.from, spring.to, spring.from_point, spring.to_point, 0.15 * radius,
                              spring_bar_colour, -1e300, std::min(spring.until, 1e300)});
  for (std::size_t i = 0; i < run.loops.size(); ++i) {
    const RecordedLoop& loop = run.loops[i];
    if (loop.at_start) continue;  // the lines of its bodies reach to it
    const auto holds = [&](const Phase& phase) {
      return std::count(phase.loops.begin(), phase.loops.end(), static_cast<int>(i)) > 0;
    };
    for (std::size_t p = 0; p < run.phases.size(); ++p) {
      if (!holds(run.phases[p])) continue;
      const int mechanism = run.phases[p].mechanism[static_cast<std::size_t>(loop.child)];
      const double begin = run.phases[p].from;
      const auto continues = [&](const Phase& phase) {
        return holds(phase) && phase.mechanism[static_cast<std::size_t>(loop.child)] == mechanism;
      };
      while (p + 1 < run.phases.size() && continues(run.phases[p + 1])) ++p;
      const double end = p + 1 < run.phases.size() ? run.phases[p + 1].from : 1e300;
      if (end <= begin) continue;
      for (Bar bar : bars_of(loop, run)) {
        bar.radius = radius, bar.colour = Drawing::colour_of(mechanism), bar.begin = begin, bar.end = end;
        drawing.bars.push_back(std::move(bar));
      }
    }
  }
}

}  // namespace

Vec3 Drawing::place(std::size_t row, int body, const Vec3& point) const {
  if (body < 0) return point;
  const double* p = pose(row, static_cast<std::size_t>(body));
  return Pose(Vec3{p[0], p[1], p[2]}, Quat{p[3], p[4], p[5], p[6]}) * point;
}

std::string Drawing::colour_of(int mechanism) {
  static constexpr const char* colours[] = {"#1f6fb5", "#d5560a", "#12805c", "#a0408a",
                                            "#8a6d00", "#0f8fa8", "#b3263e", "#5b5fc7"};
  return colours[static_cast<std::size_t>(mechanism) % std::size(colours)];
}

Drawing read_drawing(const std::filesystem::path& directory) {
  require_result_folder(directory);
  const std::filesystem::path file = directory / "bodies.csv";
  const BodyTable table(file);
  Drawing drawing;
  drawing.run = read_world(directory, table);
  drawing.status = status_in(directory / "summary.json");
  read_rows(table, file.string(), drawing);
  drawing.gap = drawing.times.size() > 1 && drawing.status.starts_with("diverged");
  drawing.colourings = colourings_of(drawing.run, drawing.times.front());
  const double length = typical_length(drawing.run);
  drawing.solids = solids_of(drawing.run, length);
  add_bars(drawing, 0.045 * length);
  return drawing;
}

}  // namespace momentree::io
