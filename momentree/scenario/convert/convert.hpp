#pragma once
// `momentree convert`: writes scenarios and models, whatever file they came from, as the text of another file.
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

struct Converted {
  std::string text;
  std::vector<Diagnostic> diagnostics;  ///< information that the text lost or expresses differently
};

/// A scenario that reads back to the same model, events and settings. Model files become bodies and joints in SI units;
/// everything else stays as the scenario writes it, with `--set` applied. `folder`: where the text will be stored; paths in it
/// are relative to that folder. Throws Error if the text would not be a valid scenario.
Converted to_toml(const Scenario& scenario, const std::string& folder);

/// The same for a reader that has the meshes themselves: each gets its name in `meshes`, by the key of its source
/// (mesh/source.hpp); the names in the scenario's own text stay as they are.
Converted to_toml(const Scenario& scenario, const std::unordered_map<std::string, std::string>& meshes);

/// A scenario without events for a model, with every body and joint written out. Bodies and joints whose names do not begin with
/// the mechanism of their root get it in front, with dots for slashes: `gripper/base`, carried by `arm/hand`, becomes
/// `arm/gripper.base`. `contact`: also what bodies touch with, the floor, and a [[contact]] for each rule, or each pair to which
/// a rule applies that no names stand for. `collision_shapes`: of which colliders are made, by collider, where that is known.
/// Meshes of others, and belts of several planes, cannot be written: throws Error.
std::string to_toml(const Model& model, const std::vector<Shape>& shapes = {}, bool contact = true,
                    const std::vector<Shape>& collision_shapes = {});

/// One mechanism of a scenario as URDF: its links, joints, limits, damping, friction and visuals. Joint kinds that URDF lacks
/// are written as chains of joints that it has, if the motion is the same (universal, cylindrical, ball). `mechanism`: its
/// name; empty if there is only one. Throws Error if URDF cannot express the mechanism: a helical joint, several roots.
Converted to_urdf(const Scenario& scenario, const std::string& mechanism, const std::string& folder);

}  // namespace momentree::io
