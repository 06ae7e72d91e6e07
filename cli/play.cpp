#include <optional>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/page.hpp>
#include <cli/serve.hpp>
#include <momentree/base/error.hpp>
#include <momentree/io/convert/convert.hpp>
#include <momentree/io/report/page.hpp>

namespace momentree::cli {

namespace {

bool has_models(const io::Scenario& scenario) {
  if (const Value::Entry* mechanisms = scenario.document->find("mechanism"))
    for (const Value& mechanism : *mechanisms->value.array())
      if (mechanism.find("model")) return true;
  return false;
}

}  // namespace

std::string playground_text(const io::Scenario& scenario, const std::vector<std::string>& overrides) {
  if (!scenario.state_files.empty())
    throw_error({"the playground does not read state documents", scenario.path,
                 "leave out 'state', or view a run with `momentree view`"});
  if (overrides.empty() && !has_models(scenario)) return scenario.text;
  return io::to_toml(scenario, "").text;
}

int play(const PlayOptions& options) {
  std::string page(playground_html());
  if (options.source.empty() && !options.overrides.empty())
    throw_error({"--set needs a scenario", "", "name the scenario that it changes"});
  if (!options.source.empty()) {
    const std::shared_ptr<const io::Scenario> scenario = load(options.source, options.overrides, notes_of(options.verbose));
    if (!scenario) return bad_input;
    page = io::playground_page(page, playground_text(*scenario, options.overrides));
  }
  return serve({std::move(page), io::content_policy(playground_html())}, listen_on(options.port), !options.no_browser);
}

}  // namespace momentree::cli
