#pragma once
// A run that plays in real time on a page: frames, snapshots to go back to, branches.
#include <memory>
#include <string_view>
#include <vector>

#include <momentree/pages/page_run.hpp>

namespace momentree::io {

/// How fast a world plays: the messages play and speed.
struct Pace {
  bool playing = false;
  double speed = 1;
  double due = 0;  ///< simulated time that is due (s)
  /// False if the message is another.
  bool obey(Message& message);
};

class PageSession {
 public:
  explicit PageSession(PageHost host);
  /// A session of a run that is there already.
  PageSession(PageHost host, std::unique_ptr<PageRun> run) : host_(std::move(host)) { now_.run = std::move(run); }

  /// Carries out a message: load, check, play, speed, rewind, undo, branch and those of PageControls. What has changed is posted.
  void obey(Message& message);
  /// `seconds` of wall-clock time have passed.
  void tick(double seconds);
  /// The present run; another one after load, and after branch.
  PageRun& run() { return *now_.run; }

 private:
  struct TimedSnapshot {
    double time;
    std::shared_ptr<const SimulationSnapshot> snapshot;
  };
  struct Branch {
    std::unique_ptr<PageRun> run;
    std::vector<TimedSnapshot> snapshots{};
    /// Frame times: a run that goes back and continues stops at the same instants as before, and so yields the same bits.
    std::vector<double> times{};
  };

  void load(Message& message);
  void rewind(Message& message);
  void undo(Message& message);
  void resume(Message& message);

  const Simulation& simulation() const { return now_.run->simulation(); }
  void take_snapshot();
  const SimulationSnapshot& snapshot_before(double time, bool strictly) const;
  /// Keeps the present run as a separate branch; returns its number.
  std::size_t keep_branch();
  void report(double seconds);
  void rewound(std::size_t saved_as);
  /// The present run is now another or at another time: posts that it `type`, "rewound" or "resumed", with a number `key`.
  void report_jump(std::string_view type, const char* key, std::size_t number, std::size_t saved_as);
  void stop(const std::string& message);

  PageHost host_;
  Branch now_;
  std::vector<Branch> branches_;  ///< that were left, by number; without a run: continued
  Pace pace_;
  KnownWorld known_;
  double progress_ = 0, stuck_ = 0;  ///< when the world last made progress, and how long it has computed since (s)
};

}  // namespace momentree::io
