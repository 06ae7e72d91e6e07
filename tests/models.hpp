#pragma once
// For tests of model files: a text that is read as a separate model, and the messages about it.
#include <string>

#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>

namespace momentree::io::models {

/// The messages of a severity, one per line.
inline std::string said(const ReadResult& result, Severity severity) {
  std::string text;
  for (const Diagnostic& each : result.diagnostics)
    if (each.severity == severity) text += (text.empty() ? "" : "\n") + each.message();
  return text;
}

/// The model that a text describes; the text must be valid.
inline Model model_of(const std::string& text, const std::string& name = "r.urdf") {
  const ReadResult result = read_scenario_text(text, name);
  CAPTURE(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return result.scenario->model;
}

/// The errors of a text that must be refused.
inline std::string errors_of(const std::string& text, const std::string& name = "r.urdf") {
  const ReadResult result = read_scenario_text(text, name);
  CHECK(!result.scenario);
  return said(result, Severity::error);
}

}  // namespace momentree::io::models
