#pragma once
// A world of the module: the run of a scenario, and data that outlive a call.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/pages/page_world.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>

#include <wasm/engine.h>

namespace momentree::wasm {

static_assert(io::motion_size == mt_motion_size && io::joint_size == mt_joint_size && io::totals_size == mt_totals_size);

/// Snapshots of a world and of its branches, by number.
struct Store {
  std::map<int, SimulationSnapshot> snapshots;
  int next = 1;
};

}  // namespace momentree::wasm

/// The opaque type of engine.h.
struct MtWorld {
  std::string text;
  std::optional<momentree::io::Scenario> scenario;
  std::unique_ptr<momentree::Simulation> simulation;
  std::vector<momentree::io::Threshold> thresholds;
  std::shared_ptr<momentree::wasm::Store> store = std::make_shared<momentree::wasm::Store>();
  int revision = 0;
  std::size_t events_seen = 0;
  momentree::io::Grip grip;
  std::vector<double> motions, joints, posed, contacts;
  double totals[mt_totals_size]{};

  /// Carries out actions as an event at this instant; the reason for a refusal is stored in `text`.
  int act(const std::vector<momentree::Action>& actions);
  /// The name of the joint or body with that number; refused if it does not exist.
  std::optional<std::string> joint_name(int joint);
  std::optional<std::string> body_name(int body, bool ground_too = false);
  /// Call whenever the topology may have changed.
  void changed() { ++revision; }
  /// Applies the current grip to a body, or removes the force from the body if there is no grip.
  void apply_grip(int body);
  /// Call after a snapshot was restored: removes the grip that it may contain.
  void after_restore();
};

namespace momentree::wasm {

/// The result of mt_load. `refusal`: why a scenario without errors still cannot be run here; empty: it can. `floor`: whether
/// the scenario got a floor that it does not have itself.
std::string load_json(const io::ReadResult& result, const std::string& refusal, bool floor);

/// A simulation of a scenario with its events scheduled.
std::unique_ptr<Simulation> start(const io::Scenario& scenario);

/// The motions (io::fill_motions) of a model at these coordinates of the joints of its tree. Loops are closed by the least change
/// of the joints whose coordinates are as in `posed`, the result of the last call, which becomes the present one. Nothing changes
/// if that is impossible.
void pose(const Model& model, const double* q, std::vector<double>& motions, std::vector<double>& posed);

}  // namespace momentree::wasm
