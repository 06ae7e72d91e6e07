#pragma once
// A run read back from its result files for a picture: bodies, poses at some instants, events, and the mechanism of each body
// between the events.
#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <momentree/io/shape.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io {

using Edge3 = std::pair<Vec3, Vec3>;

struct RecordedBody {
  std::string name, joint, kind;  ///< names of the body and of its inboard joint at the start, and the kind of that joint
  int parent = -1;                ///< at the start; −1: the ground
  Vec3 at{}, child_at{};          ///< origin of the joint's frame in the parent (or the world), and in the body (m)
  std::vector<Edge3> extent;      ///< its lines in the picture, body axes (m)
  Shape shape;
};

struct RecordedFrame {
  double time = 0;
  std::vector<Pose> poses;  ///< by body
};

/// A joint that an event made or changed, as it is after that event: bodies by number, −1 the ground.
struct RecordedJoint {
  std::string name, kind;
  int parent = -1, child = -1;
  Vec3 at{}, child_at{};
  bool locked = false;  ///< all of its DoFs
};

/// The mechanisms from the time `from` (s) on.
struct Phase {
  double from = 0;
  std::vector<int> mechanism;  ///< by body: an index in Recording::mechanisms
  std::vector<char> joined;    ///< by body: its inboard joint is that of the start, and still exists
  // Changes of joints by the event that began the phase.
  std::vector<std::string> gone;      ///< names of joints that no longer exist
  std::vector<RecordedJoint> joints;  ///< joints that it made or changed: they replace those of the same names
};

struct RecordedEvent {
  double time = 0;
  std::string name;
  std::vector<std::string> actions;
  int hits = 0;             ///< impacts on joint limits
  std::vector<int> broken;  ///< bodies whose inboard joint it broke
  std::vector<int> about;   ///< bodies whose joints it changed in any way, and those that it joined or hit
  RecordedFrame frame;      ///< the poses of the bodies: the row nearest to its time; empty if there is none
};

struct Recording {
  std::string title;
  Vec3 gravity{};
  std::vector<RecordedBody> bodies;
  std::vector<RecordedFrame> frames;
  std::vector<RecordedEvent> events;
  std::vector<Phase> phases;            ///< at least one, ordered by time
  std::vector<std::string> mechanisms;  ///< all mechanisms of the run, in order of appearance
  double every = 0;                     ///< requested time between frames (s)

  const Phase& phase_at(double time) const;
};

/// Everything except the frames: reads `model.json`, `events.jsonl` and `final.json` of a result directory if they exist.
/// `bodies`: the names of bodies.csv, in its order. Throws Error with the file and the line.
Recording read_story(const std::filesystem::path& directory, const std::vector<std::string>& bodies);

/// Reads `bodies.csv` of a result directory and, if they exist, `model.json`, `events.jsonl` and `final.json`. One frame every
/// `every` seconds; 0: every 0.2 s, or a round number that gives 4 to 60 frames if 0.2 s does not. Throws Error with the file
/// and the line.
Recording read_recording(const std::filesystem::path& directory, double every = 0);

}  // namespace momentree::io
