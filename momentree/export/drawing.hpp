#pragma once
// What is drawn of a run that was read back, independent of file formats: solids that move with bodies, bars between bodies, and
// the colours of both over time. It is what the report draws, without joint markers, floor, trails and arrows.
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <momentree/models/mesh/mesh.hpp>
#include <momentree/results/recording/body_table.hpp>
#include <momentree/results/recording/recording.hpp>

namespace momentree::io {

/// A solid in the frame of a body. Its axes are those of `at`.
struct Solid {
  enum class Kind { box, ellipsoid, cylinder, capsule, mesh };  ///< as in contact::StandardSolid, and a mesh
  Kind kind = Kind::box;
  /// That of contact::StandardSolid (m); mesh: the scale of its points (1)
  Vec3 size{1, 1, 1};
  Pose at{};
  std::string colour{};  ///< "#rrggbb"; empty: the colour of the body's mechanism
  int mesh = -1;         ///< of Kind::mesh: an index in Recording::mesh_parts; those without triangles are not drawn
};

/// A bar of the mechanism of its bodies, or a spring, between points of two bodies, from `begin` until `end` (s).
struct Bar {
  std::string name;
  int from = -1, to = -1;         ///< bodies; −1: the ground
  Vec3 from_point{}, to_point{};  ///< in the body's frame, of the ground in the world (m)
  double radius = 0;              ///< m
  std::string colour{};           ///< "#rrggbb"
  double begin = -1e300, end = 1e300;
};

/// The colours from a time on (s).
struct Colouring {
  double from = 0;
  std::vector<int> mechanism;  ///< by body: an index in Recording::mechanisms
};

struct Drawing {
  Recording run;              ///< without frames
  std::vector<double> times;  ///< of the rows (s)
  std::vector<double> poses;  ///< row by row, body by body: x y z (m) qw qx qy qz, unit quaternions with continuous signs
  bool gap = false;           ///< the run diverged: the motion between the last two rows is unknown
  std::string status;         ///< that of summary.json; empty: there is none
  std::vector<std::vector<Solid>> solids;  ///< by body
  std::vector<Bar> bars;
  std::vector<Colouring> colourings;  ///< at least one, in order of time

  const double* pose(std::size_t row, std::size_t body) const { return poses.data() + 7 * (row * run.bodies.size() + body); }
  /// A point of a body in the world; of the ground: the point itself.
  Vec3 place(std::size_t row, int body, const Vec3& point) const;
  /// "#rrggbb" of a mechanism: the colours of the report in a light theme.
  static std::string colour_of(int mechanism);
};

/// The rows with their times in a program's own numbers: of several at one of its times the last. Where the run diverged, the
/// last row but one is held until the last.
template <class Time, class Convert>
std::vector<std::pair<Time, std::size_t>> keys_of(const Drawing& drawing, const Convert& convert) {
  std::vector<std::pair<Time, std::size_t>> keys;
  for (std::size_t row = 0; row < drawing.times.size(); ++row) {
    const Time time = convert(drawing.times[row]);
    if (!keys.empty() && time <= keys.back().first)
      keys.back().second = row;
    else
      keys.emplace_back(time, row);
  }
  const std::size_t count = keys.size();
  if (!drawing.gap || count < 2) return keys;
  const Time held = std::nextafter(keys.back().first, Time{0});
  if (held > keys[count - 2].first) keys.insert(keys.end() - 1, {held, keys[count - 2].second});
  return keys;
}

/// Reads a result directory: bodies.csv and, if they exist, model.json, meshes.json, events.jsonl, final.json and summary.json.
/// The rows of a run that diverged end before the first that is not finite. Throws Error with the file and the line.
Drawing read_drawing(const std::filesystem::path& directory);

}  // namespace momentree::io
