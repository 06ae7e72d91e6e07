#pragma once
// Scenarios and models, whatever file they came from, as the text of another: `momentree convert`.
#include <string>
#include <vector>

#include <momentree/io/diagnostic.hpp>
#include <momentree/io/scenario.hpp>

namespace momentree::io {

struct Converted {
  std::string text;
  std::vector<Diagnostic> diagnostics;  ///< what the text does not say any more, and what was said differently
};

/// A scenario that reads back to the same model, events and settings: model files become bodies and joints, in SI units; what the
/// scenario says in its own words stays, `--set` included. `folder`: where the text is to stand; files that it names are named
/// from there. Throws Error where the text would not be a scenario.
Converted to_toml(const Scenario& scenario, const std::string& folder);

/// The same for a model alone, every body and joint written out: without events.
std::string to_toml(const Model& model, const std::vector<Shape>& shapes = {});

/// One mechanism of a scenario as URDF: its links, joints, limits, damping, friction and visuals. Joints that URDF has not are
/// written as chains of those that it has, where that moves alike (universal, cylindrical, ball). `mechanism`: its name; empty
/// where there is only one. Throws Error where that can't be said as URDF: a helical joint, several roots.
Converted to_urdf(const Scenario& scenario, const std::string& mechanism, const std::string& folder);

}  // namespace momentree::io
