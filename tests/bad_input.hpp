#pragma once
// For tests of invalid scenarios: a text, and the exact messages about it.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>

namespace momentree::io::bad_input {

inline const std::string head = "format = 1\n[[mechanism]]\nname = \"m\"\n";
inline const std::string one_body = head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n";
inline const std::string pinned = one_body + "[mechanism.body.joint]\nkind = \"revolute\"\n";
inline const std::string chain = head + "[mechanism.chain]\nlinks = 3\nlength = 1\nmass = 1\n";

/// The messages of a reading, one per line.
inline std::string said(const ReadResult& result) {
  std::string text;
  for (const Diagnostic& diagnostic : result.diagnostics) text += (text.empty() ? "" : "\n") + diagnostic.message();
  return text;
}

struct Case {
  std::string text;
  std::string said;  ///< location, message and hint of every problem
};

inline void check(const std::vector<Case>& cases) {
  for (const Case& each : cases) {
    CAPTURE(each.text);
    const ReadResult result = read_scenario_text(each.text, "s.toml");
    CHECK(!result.scenario);
    CHECK(said(result) == each.said);
  }
}

}  // namespace momentree::io::bad_input
