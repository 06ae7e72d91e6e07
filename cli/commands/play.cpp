#include <filesystem>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include <cli/commands.hpp>
#include <cli/commands/serve.hpp>
#include <cli/input.hpp>
#include <cli/page.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/report/page.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::cli {

namespace {

bool has_models(const io::Scenario& scenario) {
  if (const Value::Entry* mechanisms = scenario.document->find("mechanism"))
    for (const Value& mechanism : *mechanisms->value.array())
      if (mechanism.find("model")) return true;
  return false;
}

// The names of meshes in the playground's text, by the keys of their sources: those in the scenario's own text, then names that
// differ from these for the meshes of models.
std::unordered_map<std::string, std::string> names_of(const io::Scenario& scenario, const io::MeshSources& sources) {
  std::unordered_map<std::string, std::string> names;
  std::unordered_set<std::string> taken;
  const auto name = [&](const io::Shape& shape) {
    if (!shape.source || shape.source->file != scenario.path || io::is_model(scenario.path, scenario.text)) return;
    names.emplace(shape.source->key(), shape.mesh);
    taken.insert(shape.mesh);
  };
  for (const io::Shape& shape : scenario.shapes) {
    name(shape);
    for (const io::Shape& each : shape.more) name(each);
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string wanted = sources[i]->path.empty() ? "mesh" : std::filesystem::path(sources[i]->path).filename().string();
    std::string free = wanted;
    for (int n = 2; taken.contains(free); ++n) free = std::to_string(n) + '-' + wanted;
    if (names.emplace(sources[i]->key(), free).second) taken.insert(free);
  }
  return names;
}

}  // namespace

PlaygroundContent playground_content(const io::Scenario& scenario, const std::vector<std::string>& overrides) {
  if (!scenario.state_files.empty())
    throw_error({"the playground does not read state documents", scenario.path,
                 "leave out 'state', or view a run with `momentree view`"});
  const io::MeshSources sources = io::mesh_sources(scenario.shapes);
  const std::unordered_map<std::string, std::string> names = names_of(scenario, sources);
  PlaygroundContent content;
  content.text = overrides.empty() && !has_models(scenario) ? scenario.text : io::to_toml(scenario, names).text;
  if (sources.empty()) return content;
  io::PackedMeshes meshes = io::pack_meshes(sources);
  show(stderr, io::rendered(meshes.warnings));
  io::JsonWriter json(content.meshes);
  json.begin_object().key("files").begin_object();
  for (std::size_t i = 0; i < sources.size(); ++i) json.member(names.at(sources[i]->key()), static_cast<long>(i));
  json.end_object().end_object();
  content.meshes.pop_back();
  content.meshes += ", \"meshes\": " + meshes.json + "}";
  return content;
}

int play(const PlayOptions& options) {
  std::string page(playground_html());
  if (options.source.empty() && !options.overrides.empty())
    throw_error({"--set needs a scenario", "", "name the scenario that it changes"});
  if (!options.source.empty()) {
    const std::shared_ptr<const io::Scenario> scenario = load(options.source, options.overrides, notes_of(options.verbose));
    if (!scenario) return bad_input;
    const PlaygroundContent content = playground_content(*scenario, options.overrides);
    page = io::playground_page(page, content.text, content.meshes);
  }
  return serve({std::move(page), io::content_policy(playground_html())}, live::listen_on(options.port), !options.no_browser);
}

}  // namespace momentree::cli
