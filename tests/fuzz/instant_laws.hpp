#pragma once
// Laws that hold at every instant of a run, computed here from what a world reports: motions, accelerations and forces.
#include <map>
#include <string>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/fuzz/findings.hpp>

namespace momentree::fuzz {

/// Looks at one run: at its rows, and at the state after every step.
class InstantLaws {
 public:
  InstantLaws(const io::Scenario& scenario, Findings& found) : scenario_(scenario), found_(found) {}
  /// At a row, or anywhere between two steps.
  void look(const Simulation& simulation);
  /// At the end of every step, before and after the events of that instant.
  void follow(const Simulation& simulation);

 private:
  struct Instant {
    double time = 0;
    bool stepped = false;  // contacts are stepped through
    std::vector<BodyMotion> motions;
    std::vector<BodyAcceleration> accelerations;
  };
  void require_equations_of_motion(const World& world);
  void require_contact_law(const World& world, bool stepped);
  void require_nothing_below_floor(const World& world);
  void require_joints(const World& world, bool stepped);
  void require_cables(const World& world);
  void require_totals(const World& world);
  void require_rest(const Simulation& simulation);
  void require_motion_follows_accelerations(const std::string& at);

  const io::Scenario& scenario_;
  Findings& found_;
  std::string at_;
  std::vector<Instant> last_;             // the last three without an event between them
  std::map<std::string, double> beyond_;  // by joint and DoF: how far it is beyond a stop that it was given there
  std::size_t followed_ = 0;              // events until the last step
  std::vector<BodyMotion> at_rest_;       // at a row; it was the same at `rested_` rows, without events since
  std::size_t rested_ = 0, rest_events_ = 0;
};

}  // namespace momentree::fuzz
