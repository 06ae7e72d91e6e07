#pragma once
// Names that a scenario can give: those of models made in code may have no mechanism.
#include <string>
#include <vector>

#include <momentree/model/model.hpp>

namespace momentree::io {

struct ScenarioName {
  std::string body, joint;
};

/// By body: the names of the body and its joint, with the mechanism of their root in front where they lack it.
std::vector<ScenarioName> scenario_names(const Model& model);

/// The model with these names.
Model with_scenario_names(const Model& model);

}  // namespace momentree::io
