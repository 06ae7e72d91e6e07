#pragma once
// The parts of a view: what it has told its pages, and what they have asked for.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/io/page_world/page_world.hpp>
#include <momentree/live/feed.hpp>
#include <momentree/live/listener.hpp>
#include <momentree/live/view.hpp>

namespace momentree::live {

struct View::Impl {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::duration<double> frame_time{1.0 / 60};

  Impl(Simulation& simulation_, ViewOptions options_, const io::Scenario* scenario);
  ~Impl() { close(); }

  // view.cpp: to the pages
  void close();
  void serve(Listener listener, const std::string& meshes);
  /// Everything that a page needs to show the present state.
  void greet(bool all);
  /// What has changed since the last call, and the present frame.
  void tell();
  std::string frame() const;
  std::string frame_message();
  std::string sliders_json() const;

  // commands.cpp: from the pages
  void obey(const std::string& text);
  void carry_out(const Value& message);
  void act(const Value& action);
  void set_joint(const Value& message);
  void apply(const std::vector<Action>& actions);
  void grab(const Value& message);
  void pull(const Value& message);
  void release();
  void apply_grip();
  void move_slider(const Value& message);
  void refuse(const std::string& why);

  Simulation& simulation;
  ViewOptions options;
  std::string scenario_text;  ///< JSON: see io::scenario_json
  std::vector<io::Threshold> thresholds;
  double step = 0;  ///< of a method with fixed steps (s); 0: the method is adaptive
  Feed feed;
  std::vector<Slider> sliders;
  std::vector<std::string> warnings;
  std::string address;

  bool playing = true, stopped = false;
  double speed = 1, due = 0;  ///< simulated time that is due (s)
  double spent = 0;           ///< on the steps since the last frame (s)
  Clock::time_point paced = Clock::now(), told = Clock::now();
  io::Grip grip;

  // What the pages know.
  std::uint64_t revision = 0;
  std::size_t events = 0;
  int bodies = 0;
  double time = 0;
  bool changed = false;  ///< parameters or gravity, which no event reports

  std::atomic<bool> ending = false;
  std::thread server;
};

}  // namespace momentree::live
