#pragma once
// Contacts in the steps of a simulation: what happens at stops and contacts after a step, and which islands are stepped through.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/contact/contact_start.hpp>
#include <momentree/simulate/contact/contacts.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/stepping/contact_steps.hpp>

namespace momentree {

class ContactRun {
 public:
  /// `tolerance`: of the instants of contacts (s). `located_step`: the length of steps in which contacts are located (s); 0: the
  /// method adapts them.
  ContactRun(Simulation::Impl& run, double tolerance, double located_step);

  ContactGeometry geometry;
  Contacts contacts;
  ContactsBetweenRuns between_runs;
  ContactSteps steps;
  std::unique_ptr<Integrator> stepper;  ///< takes the place of the method where contacts are stepped through; only with contacts
  bool method_steps = false;            ///< the method itself steps through contacts
  SteppingState stepping;
  bool as_built = true;       ///< the state is that of the model, in which `resolve` pushes bodies apart
  bool keeps_closed = false;  ///< the next run may begin with the closed contacts

  /// Contacts that are stepped through instead of being located: of all bodies, or of some islands.
  bool steps_through() const { return stepping.all || method_steps; }
  bool some_step() const { return stepping.on && !stepping.all; }
  /// Pushes bodies apart that overlap; throws Error if that is impossible.
  void separate();

  // A step.
  std::span<const Watch> watches(double& h);
  void note_before_step();
  /// True if contacts brought in energy in this step.
  bool gained_energy();
  void undo_step();
  void begin_stepping(const std::string& why, const std::vector<int>& at);
  bool resolve_after_step(double h);
  bool resolve_in_turn(bool due, bool after_step = false);
  /// Impacts of bodies, and contacts that close, open, slip or stick. False: there is no solution, and the run ends.
  /// `after_step`: not at the start, nor after an action, where an overlap is a mistake.
  bool resolve_contacts(bool after_step = false);
  void judge_steps();
  void find_forces_of_steps();

  // Between steps.
  void update_pending();
  std::vector<bool> stepped_bodies() const;
  SteppingState stepping_state() const;
  void continue_stepping(const SteppingState& from);
  void check_contacts_of_document(const SteppingState& from);
  double unloaded();
  bool overlaps_more_than(double depth);
  bool overlaps_as_before(double before);
  bool overlaps_at_start();
  Event pass_of(int one, int other, const Vec3& point, const Vec3& normal) const;

 private:
  std::optional<Contacts::Unresolved> resolve_stops_and_contacts();
  void report_passes();
  void note_overlaps();
  void update_islands();
  void join_touched_islands();
  void step_islands(double h);
  void try_to_locate(const Islands& islands, int number);
  void after_contact_step();
  void report_stepping(const char* what, const std::string& why, const std::vector<int>& bodies);
  bool flood_of_changes(std::size_t first);
  double share_of_island(double since);
  std::size_t points_at_events(std::size_t first);
  std::vector<int> bodies_of_flood() const;
  void report_overlap(const std::string& what);

  Simulation::Impl& run_;
  struct BeforeStep {
    State state{};
    EnergyLedger ledger{};
    double energy = 0, proposal = 0;
    std::vector<double> kinetic;  // by island
  };
  BeforeStep before_step_;  // with closed contacts
  std::vector<Watch> all_watches_;
};

}  // namespace momentree
