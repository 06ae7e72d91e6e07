#pragma once
// The run of a scenario that a page owns, with each message answered at once.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/pages/message.hpp>
#include <momentree/pages/page_controls.hpp>
#include <momentree/pages/page_world.hpp>
#include <momentree/scenario/scenario.hpp>

namespace momentree::io {

/// What a run calls: the page gets its messages, JSON on one line and the bytes of the frame in it, and has a clock (s).
struct PageHost {
  std::function<void(const std::string& text, std::span<const unsigned char> frame)> post;
  std::function<double()> clock;
};

/// {"type": "checked", "diagnostics": …}: the problems of a scenario.
std::string checked_json(std::string_view text);

class PageRun {
 public:
  explicit PageRun(PageHost host) : host_(std::move(host)) {}

  /// Reads a scenario (TOML) and posts "loaded". False, and the run stays as it was, if it has errors. Files are not opened:
  /// model files and state documents are errors. `floor`: see put_on_floor().
  bool load(std::string_view text, bool floor);
  bool loaded() const { return simulation_ != nullptr; }

  /// Answers a message. What cannot be done is posted as "refused".
  void obey(Message& message);

  // Of a loaded run:
  const Simulation& simulation() const { return *simulation_; }
  PageControls& controls() { return *controls_; }
  /// Steps to a time (s), for at most `budget` seconds of the clock; then interrupted.
  RunResult run(double time, double budget);
  void restore(const SimulationSnapshot& snapshot);
  /// Returns to just before an event; false if the history does not reach back that far.
  bool undo(int event, bool again = false);
  /// An independent run from here, without the grip.
  std::unique_ptr<PageRun> branch() const;
  void post_frame(double seconds = 0) const;

  /// `state`: time, revision of the topology (another number whenever it may have changed), number of events, of bodies, of rows
  /// of joints. `reactions`: joints with reactions. `pose`: motions after the message "pose", and `posed` the coordinates.
  enum class Numbers { state, motions, joints, reactions, totals, contacts, pose, posed };
  /// Valid until the next call.
  const std::vector<double>& numbers(Numbers which);

 private:
  void begin(std::unique_ptr<Simulation> simulation);
  /// Removes the grip that a restored run may contain.
  void after_restore();
  void post(std::string_view type, std::string_view key, std::string_view json) const {
    host_.post(message_json(type, key, json), {});
  }
  void run_message(Message& message);
  void pose_message(Message& message);

  /// Snapshots of a run and of its branches, by number.
  struct Store {
    std::map<int, SimulationSnapshot> snapshots;
    int next = 1;
  };

  PageHost host_;
  std::shared_ptr<const Scenario> scenario_;
  std::unique_ptr<Simulation> simulation_;
  std::optional<PageControls> controls_;
  std::vector<Threshold> thresholds_;
  std::shared_ptr<Store> store_ = std::make_shared<Store>();
  std::vector<double> numbers_, pose_, posed_;
};

}  // namespace momentree::io
