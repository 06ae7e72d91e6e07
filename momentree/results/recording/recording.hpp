#pragma once
// A run read back from its result files for a picture: bodies, poses at some instants, events, and the mechanism of each body
// between the events.
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/results/recording/meshes.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>

namespace momentree::io {

using Edge3 = std::pair<Vec3, Vec3>;

struct RecordedBody {
  std::string name, joint, kind;  ///< names of the body and of its inboard joint at the start, and the kind of that joint
  int parent = -1;                ///< at the start; −1: the ground
  Vec3 at{}, child_at{};          ///< origin of the joint's frame in the parent (or the world), and in the body (m)
  std::vector<Edge3> extent;      ///< its lines in the picture, body axes (m)
  Shape shape;
  std::vector<int> meshes{};  ///< by shape, `shape` first: the number in meshes.json; −1: it is no mesh, or none that was read
  double mass = 0;            ///< kg
  Vec3 com{};                 ///< m
  std::optional<Sym3> inertia{};  ///< about the centre of mass (kg m²); none: unknown
};

/// A spring between points of two bodies; body −1: the ground.
struct RecordedSpring {
  std::string name;
  int from = -1, to = -1;
  Vec3 from_point{}, to_point{};  ///< in the body's frame, of the ground in the world (m)
  double until = HUGE_VAL;        ///< when it broke (s)
};

/// A plane that bodies can lie on.
struct RecordedPlane {
  Vec3 point{}, normal{0, 0, 1};  ///< world axes (m)
};

struct RecordedFrame {
  double time = 0;
  std::vector<Pose> poses;  ///< by body
};

/// A joint that closes a loop, in addition to the inboard joints. One that takes the place of a broken inboard joint stays here.
struct RecordedLoop {
  std::string name, kind;
  int parent = -1, child = -1;  ///< bodies; parent −1: the ground
  Vec3 at{}, child_at{};        ///< origin of its frame in the parent (or the world), and in the child (m)
  bool at_start = false;        ///< the model has it: the extents of its bodies reach to it
  friend bool operator==(const RecordedLoop&, const RecordedLoop&) = default;
};

/// The mechanisms from the time `from` (s) on.
struct Phase {
  double from = 0;
  std::vector<int> mechanism;  ///< by body: an index in Recording::mechanisms
  std::vector<char> joined;    ///< by body: its inboard joint is that of the start, and still exists
  std::vector<int> loops;      ///< joints that close loops: indices in Recording::loops
};

struct RecordedEvent {
  double time = 0;
  std::string name;
  std::vector<std::string> actions;
  int impacts = 0;                  ///< on joint limits
  bool contact = false;             ///< of bodies that touch
  std::vector<int> broken;          ///< bodies whose inboard joint it broke
  std::vector<int> opened;          ///< joints that closed loops and that it broke: indices in Recording::loops
  std::vector<int> broken_springs;  ///< indices in Recording::springs
  RecordedFrame frame;              ///< the poses of the bodies: the row nearest to its time; empty if there is none
};

struct Recording {
  std::filesystem::path folder;  ///< the result
  std::string title;
  Vec3 gravity{};
  std::vector<RecordedBody> bodies;
  std::vector<RecordedSpring> springs;
  std::vector<RecordedPlane> planes;
  std::vector<GroundShape> ground;
  std::vector<RecordedFrame> frames;
  std::vector<RecordedEvent> events;
  std::vector<RecordedLoop> loops;      ///< all joints of the run that close loops
  std::vector<Phase> phases;            ///< at least one, ordered by time
  std::vector<std::string> mechanisms;  ///< all mechanisms of the run, in order of appearance
  std::vector<MeshPart> mesh_parts;     ///< of meshes.json
  std::vector<MeshParts> meshes;        ///< by their numbers
  double every = 0;                     ///< requested time between frames (s)

  const Phase& phase_at(double time) const;
  /// The parts of the mesh that is a shape of the body: its `shape`, and then those of `more`. None if it is no mesh.
  MeshParts parts_of(const RecordedBody& body, std::size_t shape) const;
};

/// The point of a body's lines that is nearest to a point, in its axes; `otherwise`, if none is nearer than `least` (m).
Vec3 nearest_on(const RecordedBody& body, const Vec3& point, const Vec3& otherwise, double least = HUGE_VAL);

/// Throws Error unless the folder of a result exists.
void require_result_folder(const std::filesystem::path& directory);

/// A document of a result; nothing if the file does not exist. Throws Error with its place.
std::optional<Value> find_document(const std::filesystem::path& file);

/// Calls back with each line of `events.jsonl`, as a document and as text, and its place, if the file exists. Leaves out a last
/// line that an interrupted run was still writing. Throws Error with the file and the line.
void for_each_event(const std::filesystem::path& file,
                    const std::function<void(const Value& document, const std::string& line, const std::string& where)>& use);

class BodyTable;

/// The run of a result directory without its poses: `frames` and the events' are empty. `table`: that of its
/// bodies.csv. Throws Error with the file and the line.
Recording read_world(const std::filesystem::path& directory, const BodyTable& table);

/// Reads `bodies.csv` of a result directory and, if they exist, `model.json`, `events.jsonl` and `final.json`. One frame every
/// `every` seconds; 0: every 0.2 s, or a round number that gives 4 to 60 frames if 0.2 s does not. Throws Error with the file
/// and the line.
Recording read_recording(const std::filesystem::path& directory, double every = 0);

}  // namespace momentree::io
