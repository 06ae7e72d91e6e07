#pragma once
// Runs that stop and continue, compared with one that does not stop.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <cli/input.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

inline io::Scenario read_restarted(const std::string& text) {
  io::ReadResult result = io::read_scenario_text(text, "s.toml");
  INFO(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}

struct RestartedRun {
  io::Session session;
  bool adaptive;
  std::vector<std::string> events;
  RestartedRun(const io::Scenario& scenario, const std::string& state, double until)
      : session(scenario, documents_of(state, scenario.model)), adaptive(is_adaptive(scenario.integration.method)) {
    static_cast<void>(session.schedule());
    session.simulation().observe(scenario.output_every, [](const World&) { return true; });
    REQUIRE(session.simulation().run_until(until) == Status::ok);
    for (const Event& event : session.simulation().events())
      events.push_back(event.name + " " + std::to_string(event.time) + " " +
                       (event.actions.empty() ? event.contact.one : event.actions.front().text()));
  }
  std::string state() const {
    StepMemory memory = step_memory(session.simulation());
    memory.work = 0;
    return io::state_json(session.simulation().world(), session.armed(), memory);
  }
};

inline void check_restarts(const io::Scenario& scenario, double until, const std::vector<double>& stops) {
  const io::test::TemporaryFolder folder;
  const RestartedRun whole(scenario, "", until);
  for (const double stop : stops) {
    CAPTURE(stop);
    const RestartedRun first(scenario, "", stop);
    const std::string file = folder / "state.json";
    io::write_text_file(
        file, io::state_json(first.session.simulation().world(), first.session.armed(), step_memory(first.session.simulation())));
    CHECK(RestartedRun(scenario, file, stop).state() == first.state());  // nothing happens again
    const RestartedRun second(scenario, file, until);
    std::vector<std::string> events = first.events;
    events.insert(events.end(), second.events.begin(), second.events.end());
    CHECK(events == whole.events);
    CHECK(second.state() == whole.state());
    // Sums of work may differ by rounding: steps are evaluated again to find peaks of the load that breaks a joint.
    if (whole.adaptive)
      CHECK(step_memory(second.session.simulation()).work ==
            doctest::Approx(step_memory(whole.session.simulation()).work).epsilon(1e-12));
  }
}

}  // namespace momentree::cli
