#pragma once
// The parts of a view: what it has told its pages, and what they have asked for.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <momentree/live/feed.hpp>
#include <momentree/live/listener.hpp>
#include <momentree/live/view.hpp>
#include <momentree/pages/page_session.hpp>
#include <momentree/scenario/scenario.hpp>

namespace momentree::live {

struct View::Impl {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::duration<double> frame_time{1.0 / 60};

  Impl(Simulation& simulation_, ViewOptions options_, const io::Scenario* scenario);
  ~Impl() { close(); }

  // view.cpp: to the pages
  void close();
  void serve(Listener listener, const std::string& meshes);
  /// The present world for pages that open from now on, and anew for those that are open.
  void reload();
  /// What pages that open from now on get first: what the others know.
  std::vector<std::string> greeting() const;
  /// What has changed since the last call, and the present frame.
  void tell();
  void tell_frame(bool now);
  std::string sliders_json() const;

  // commands.cpp: from the pages
  void obey(const std::string& text);
  void move_slider(io::Message& message);
  void stop();

  Simulation& simulation;
  ViewOptions options;
  io::Scenario scenario;  ///< what io::scenario_json needs of it
  std::vector<io::Threshold> thresholds;
  double step = 0;  ///< of a method with fixed steps (s); 0: the method is adaptive
  Feed feed;
  std::vector<Slider> sliders;
  std::vector<std::string> warnings;
  std::string address;

  bool stopped = false;
  /// How fast simulated time passes.
  struct Pace : io::Pace {
    double spent = 0;  ///< on the steps since the last frame (s)
    Clock::time_point paced = Clock::now(), told = Clock::now(), framed = Clock::now();
  };
  Pace pace;
  io::PageControls controls;

  /// What the pages know, as JSON where it is text.
  struct Known {
    std::string model_text, events_text, frame_text;
    io::KnownWorld world;
    int bodies = 0;
    double time = 0;
    Vec3 gravity{};
    bool playing = true, sliders_moved = false;
  };
  Known known;

  std::atomic<bool> ending = false;
  std::thread server;
};

}  // namespace momentree::live
