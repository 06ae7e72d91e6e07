#pragma once
// Properties that hold for reading any text.
#include <algorithm>
#include <cstdlib>
#include <string>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/scenario.hpp>

namespace momentree::fuzz {

inline void require(bool holds) {
  if (!holds) std::abort();
}

/// A terminal displays these lines, with no control characters to interpret.
inline void require_visible(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  require(first_invisible(text) == std::string::npos);
}

/// Either a scenario or errors; messages and names are printable.
inline void judge(const io::ReadResult& result) {
  require(result.scenario.has_value() != io::has_errors(result.diagnostics));
  const std::string messages = io::rendered(result.diagnostics);
  require(messages.empty() == result.diagnostics.empty());
  require_visible(messages);
  if (!result.scenario) return;
  require_visible(result.scenario->title);
  for (const BodySpec& body : result.scenario->model.bodies()) require_visible(body.name + body.joint_name);
  require(result.scenario->shapes.size() == static_cast<std::size_t>(result.scenario->model.size()));
}

}  // namespace momentree::fuzz
