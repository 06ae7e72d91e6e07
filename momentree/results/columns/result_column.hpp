#pragma once
// One column of bodies.csv, joints.csv, energy.csv or springs.csv, read from a running simulation.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/results/columns/result_columns.hpp>

namespace momentree::io {

class ResultColumn {
 public:
  /// Finds a column by its name in a table: "time", "tug/gripper.x", "arm/elbow.q0", "kinetic",
  /// "rope.tension". Joints have the columns of
  /// reactions, too. `joints`: those that exist or that events will make. If there is none, `problem` gets the reason and a hint.
  static std::optional<ResultColumn> find(std::string_view name, const World& world, const std::vector<JointKinds>& joints,
                                          Diagnostic& problem);

  const std::string& name() const { return name_; }
  /// Its SI unit: "m", "rad/s"; empty for numbers without one.
  const std::string& unit() const { return unit_; }
  /// The number in the present state, also of a simulation of another model; NaN if the body or the joint, or its coordinate,
  /// does not exist or has another unit. Quaternions have the sign with w >= 0.
  double value(const Simulation& simulation) const;
  /// Whether it is a number of the energy ledger: energy dissipated, work of forces, error of the balance.
  bool of_ledger() const;

 private:
  enum class Of { time, body, joint, energy, spring };
  ResultColumn() = default;

  std::string name_, unit_;
  Of of_ = Of::time;
  BodyId body_{-1};    ///< where it was found
  std::string owner_;  ///< the name of the body, the joint or the spring
  char group_ = 0;     ///< of a joint: q, v, p, f or m
  std::size_t place_ = 0;
};

}  // namespace momentree::io
