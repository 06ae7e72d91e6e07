#pragma once
// A run read back from its result files, as far as a picture needs it: bodies, poses at some instants, events, and which
// mechanism each body belongs to between the events.
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
  std::string name, joint, kind;  ///< of the body, of its inboard joint at the start, and that joint's kind
  int parent = -1;                ///< at the start; −1: the ground
  Vec3 at{}, child_at{};          ///< origin of the joint's frame in the parent (or the world), and in the body
  std::vector<Edge3> extent;      ///< what is drawn of it, body axes
  Shape shape;
};

struct RecordedFrame {
  double time = 0;
  std::vector<Pose> poses;  ///< by body
};

/// A joint that an event made or changed, as it is from then on: bodies by number, −1 the ground.
struct RecordedJoint {
  std::string name, kind;
  int parent = -1, child = -1;
  Vec3 at{}, child_at{};
  bool locked = false;  ///< all of its freedoms
};

/// Who belongs together from `from` on.
struct Phase {
  double from = 0;
  std::vector<int> mechanism;  ///< by body: a number in Recording::mechanisms
  std::vector<char> joined;    ///< by body: its inboard joint is that of the start, and holds
  // What the event that began it did to joints.
  std::vector<std::string> gone;      ///< names of those that do not exist any more
  std::vector<RecordedJoint> joints;  ///< those that it made or changed: they replace what had their names
};

struct RecordedEvent {
  double time = 0;
  std::string name;
  std::vector<std::string> actions;
  int hits = 0;             ///< impacts on joint limits
  std::vector<int> broken;  ///< bodies whose inboard joint it broke
  std::vector<int> about;   ///< bodies whose joints it changed in any way, and those that it joined or hit
  RecordedFrame frame;      ///< where the bodies were: the row next to its time; empty if there is none
};

struct Recording {
  std::string title;
  Vec3 gravity{};
  std::vector<RecordedBody> bodies;
  std::vector<RecordedFrame> frames;
  std::vector<RecordedEvent> events;
  std::vector<Phase> phases;            ///< at least one, by time
  std::vector<std::string> mechanisms;  ///< all that ever were, in the order in which they appeared
  double every = 0;                     ///< time between frames, as asked for (s)

  const Phase& phase_at(double time) const;
};

/// All but the frames: reads `model.json`, `events.jsonl` and `final.json` of a result directory where they exist. `bodies`: the
/// names of bodies.csv, in its order. Throws Error that names the file and the line.
Recording read_story(const std::filesystem::path& directory, const std::vector<std::string>& bodies);

/// Reads `bodies.csv` and, where they exist, `model.json`, `events.jsonl` and `final.json` of a result directory.
/// One frame every `every` seconds; 0: every 0.2 s, or a round number that gives 4 to 60 frames where that does not.
/// Throws Error that names the file and the line.
Recording read_recording(const std::filesystem::path& directory, double every = 0);

}  // namespace momentree::io
