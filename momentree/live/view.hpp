#pragma once
// A page in the browser that shows a simulation while the program runs it, and from which it can be paused, slowed down and
// changed.
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <momentree/models/import/shape.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {
struct Scenario;
}

namespace momentree::live {

struct ViewOptions {
  std::string title{};
  std::vector<io::Shape> shapes{};  ///< by body number; bodies without a shape are drawn by their extent and inertia
  int port = 0;                     ///< 0: any free port
  bool open_browser = true;         ///< where there is a screen
  bool paused = false;              ///< the run begins when the reader presses play
  double speed = 1;                 ///< of run_until(): simulated seconds per second
};

/// A slider on the page: a number that the program uses as it likes.
struct Slider {
  std::string name;
  double least = 0, most = 1, value = 0;
  std::string unit{};
  /// Called from update() and run_until() with a new value; may change the simulation. Empty: the program reads value().
  std::function<void(double)> changed{};
};

/// Serves the page from a thread of its own, to this machine's user alone. The simulation is read and changed only by the thread
/// that calls update() or run_until(), between steps; it must outlive the view and stay where it is.
///
///     momentree::live::View view(sim, {.title = "Crane"});
///     view.slider({.name = "wind", .most = 20, .unit = "m/s"});
///     view.run_until(60);  // in real time
///
/// or, in a loop of the program's own, as fast as it goes:
///
///     while (sim.time() < 60 && view.update()) sim.step(1e-3);
class View {
 public:
  /// Starts to serve. Throws Error if the port is in use, and for a speed that is not positive and finite. Meshes that cannot be
  /// drawn are left out: see warnings().
  explicit View(Simulation& simulation, ViewOptions options = {});
  /// The same for the simulation of a scenario: with its title, shapes and instants.
  View(Simulation& simulation, const io::Scenario& scenario, ViewOptions options = {});
  ~View();
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  /// The page's address. It ends with a random key, so that other users of this machine cannot read the page.
  const std::string& address() const;
  const std::vector<std::string>& warnings() const;

  /// Adds a slider. Throws Error for a name that is taken, and for numbers that are not finite or not in order.
  void slider(Slider slider);
  /// The value of a slider. Throws Error for an unknown name.
  double value(const std::string& slider) const;

  /// Shows the present state, at most sixty times per second, and does what the reader asked for. While the page is paused,
  /// waits. Returns false once the reader has pressed Stop.
  bool update();

  /// Steps to `time` (s) at the page's speed, stopping after whole steps of methods with fixed steps: without events, it takes
  /// the steps of Simulation::run_until(); after an event within a step, the one to the end of the frame is shorter. Returns
  /// Status::interrupted once the reader has pressed Stop, or `goes_on`, which is called for each frame, returns false.
  RunResult run_until(double time = std::numeric_limits<double>::infinity(), const std::function<bool()>& goes_on = {});

  // The parts of update() and run_until(), for programs that wait in their own way.

  /// Shows the present state and does what the reader asked for, without waiting.
  void exchange();
  bool playing() const;
  bool stopped() const;
  /// Waits until the reader has done something, at most for this time.
  void wait(std::chrono::nanoseconds most);
  /// The time (s) to which to step now for a run at the page's speed, at most `until`; the present one: wait first.
  double next(double until);
  /// Reports the result of stepping to that time: a run that could not go on is paused, with its reason on the page.
  void report(const RunResult& result);
  /// The number of times that a page has connected.
  int pages() const;
  /// Stops serving; pages that are open keep what they have shown, and a body that is grabbed is released. The destructor does
  /// so, too.
  void close();
  /// The same without a change of the simulation: a grip stays, as the function of its body.
  void abandon();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace momentree::live
