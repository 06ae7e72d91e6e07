#pragma once
// A run kept in memory: its rows, from which columns, tables and pages are made afterwards.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/results/results.hpp>
#include <momentree/results/summary.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// The columns of one joint, a row per instant; NaN where the joint does not exist or has fewer coordinates. Quaternions are
/// continuous in sign.
struct JointRows {
  std::size_t nq = 0, nv = 0;   ///< of the widest kind that the joint had
  std::vector<double> q, v, p;  ///< rows × nq, rows × nv, rows × nv
  std::vector<double> a;        ///< rows × nv, with reactions: time derivatives of v
  std::vector<double> wrench;   ///< rows × 6, with reactions: JointForces::reaction, force (N) then torque (N m)
};

/// Rows are whole states, so a record holds three numbers per DoF and instant. Everything else is evaluated from them when asked
/// for.
class RunRecord {
 public:
  /// `reactions`: also keep accelerations and the reactions of joints.
  RunRecord(const Simulation& simulation, RunOrigin origin, std::string model_json, bool reactions);

  /// Adds the present state as a row; of several at one instant the last one counts.
  void observe(const Simulation& simulation);
  /// Adds the last row, the events of the run and the documents. `status`: as in summary.json.
  void finish(const Simulation& simulation, std::string status, const Armed& armed);

  std::size_t rows() const { return times_.size(); }
  const std::vector<double>& times() const { return times_; }
  const std::string& status() const { return status_; }
  const std::string& summary() const { return summary_; }
  const std::string& final_state() const { return final_; }
  const std::vector<Event>& events() const { return events_; }
  const Model& model() const { return model_; }
  bool has_reactions() const { return reactions_; }
  /// Names of all joints that the run had, in the order in which they appeared.
  std::vector<std::string> joints() const;

  /// Throws Error, with the nearest name, for an unknown joint.
  [[nodiscard]] JointRows joint(std::string_view name) const;
  /// Rows of 13 numbers: position (m), quaternion (w, x, y, z), linear velocity (m/s) and angular velocity (rad/s) of the body's
  /// frame, world axes; NaN for a body that is not in the world.
  [[nodiscard]] std::vector<double> body(BodyId body) const;
  /// Rows of 14 numbers, as in energy.csv without `time`.
  [[nodiscard]] std::vector<double> energies() const;
  static const std::vector<std::string>& energy_columns();
  /// Rows of 3 numbers, as in springs.csv: length (m), rate (m/s) and tension (N) of a spring; NaN once it is broken. Throws
  /// Error, with the nearest name, for an unknown one.
  [[nodiscard]] std::vector<double> spring(std::string_view name) const;
  /// The state of a row.
  [[nodiscard]] WorldSnapshot state(std::size_t row) const;
  /// The run at a row, with its events and its energy balance, which the simulation can be restored to.
  [[nodiscard]] SimulationSnapshot snapshot(std::size_t row) const;

  /// The text of contacts.csv: only its header without reactions.
  [[nodiscard]] std::string contact_table() const;

  /// Writes the files that `momentree run` writes. `report`: the content of report.html; empty: no report. `meshes`: that of
  /// meshes.json; empty: none. Returns the folder.
  std::string write(const std::string& folder, const ReportPage& report, const std::string& meshes = {}) const;

 private:
  struct Layout {
    std::string name;
    int first_q = 0, nq = 0, first_p = 0, nv = 0;
    const char* q_units = "";
    int loop = -1;  ///< the number of a loop joint, whose numbers are in a part of their own
  };
  // Rows of one topology.
  struct Epoch {
    std::size_t first_row = 0;
    std::uint64_t revision = 0;
    WorldSnapshot world;
    std::vector<Layout> joints;  // by joint number, then those of loops
    int nq = 0, nv = 0;
    int loop_q = 0, loop_v = 0, loops = 0;  // coordinates and velocities of loop joints, and their number
  };
  // What a row adds to its state; the events are shared by rows between which none happened.
  struct Progress {
    SimulationSnapshot run;
    std::shared_ptr<const std::vector<EventStatus>> armed;
  };
  void add_progress(const Simulation& simulation);
  std::vector<JointKinds> joint_kinds() const;
  void begin_epoch(const Simulation& simulation);
  void add_loops(const World& world, const Epoch& epoch);
  std::size_t row_size(const Epoch& epoch) const;
  void drop_last_row();
  template <class Visit>
  void each_row(const Visit& visit) const;
  template <class Visit>
  void each_world(const Visit& visit) const;

  RunOrigin origin_;
  Model model_;
  std::string model_json_, status_, summary_, final_;
  bool reactions_;
  std::vector<Epoch> epochs_;
  std::vector<double> times_,
      numbers_;                       // of each row q, v, p; of loops q, v, turns; with reactions a and a wrench for each joint
  std::vector<std::size_t> offsets_;  // of the rows in numbers_
  std::vector<EnergyBalance> energy_;
  std::vector<Progress> progress_;
  std::vector<std::string> contacts_;  // by row, with reactions: its rows of contacts.csv
  std::size_t events_before_ = 0;
  std::vector<Event> events_;
};

}  // namespace momentree::io
