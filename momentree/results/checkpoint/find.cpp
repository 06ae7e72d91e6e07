#include <nlohmann/json.hpp>

#include <momentree/base/error.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

namespace {

constexpr const char* again = "or run without --resume to start again from the beginning";

void require_same_input(const RunInput& then, const RunInput& now, const std::string& path) {
  const auto refuse = [&](const std::string& what, const std::string& hint) { throw_error({what, path, hint + ", " + again}); };
  if (then.version != now.version)
    refuse("this checkpoint was written by momentree " + then.version + ", and this is " + now.version,
           "resume with that version");
  if (then.scenario != now.scenario)
    refuse("this checkpoint is of another scenario, or of other values of --set and --until, or a model file has changed",
           "resume with the same files and options");
  if (then.documents != now.documents)
    refuse("the state document that the scenario names has changed since this checkpoint", "restore it");
  if (then.reactions != now.reactions)
    refuse(then.reactions ? "this run records reactions" : "this run does not record reactions",
           then.reactions ? "give --reactions" : "leave out --reactions");
}

}  // namespace

RunInput run_input(const Scenario& scenario, bool reactions) {
  Checksum documents;
  for (const StateFile& file : scenario.state_files) documents.add(read_text_file(file.file) + '\n');
  return {MOMENTREE_VERSION, scenario.hash, std::to_string(documents.value()), reactions};
}

std::optional<Interrupted> find_checkpoint(const std::string& destination, const RunInput& input) {
  Interrupted found;
  found.directory =
      ResultDirectory::reopen(destination,
                              {"summary.json", "model.json", "events.jsonl", "bodies.csv", "joints.csv", "energy.csv",
                               "springs.csv", "contacts.csv", "meshes.json", "final.json", checkpoint_file},
                              checkpoint_file);
  if (!found.directory) return std::nullopt;
  const std::filesystem::path& folder = found.directory->working();
  found.path = (folder / checkpoint_file).string();
  found.checkpoint = read_checkpoint(read_text_file(found.path, Links::refuse), found.path);
  require_same_input(found.checkpoint.input, input, found.path);
  for (const RecorderState::Table& table : found.checkpoint.record.tables)
    require_unchanged((folder / table.file).string(), table.mark);
  return found;
}

bool is_complete(const std::string& destination, const RunInput& input) {
  const std::string path = (std::filesystem::path(destination) / "summary.json").string();
  if (!is_there(path)) return false;
  const auto summary = nlohmann::json::parse(read_text_file(path), nullptr, false);
  if (!summary.is_object()) return false;
  const auto text = [](const nlohmann::json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const auto scenario = summary.find("scenario");
  if (text(summary, "status") != "done" || text(summary, "version") != input.version || scenario == summary.end() ||
      !scenario->is_object() || text(*scenario, "hash") != input.scenario)
    return false;
  if (input.reactions && summary.value("reactions", false) == false)
    throw_error({"these results are complete, but have no reactions", destination,
                 "leave out --resume to run again, or name another folder with --out"});
  if (is_there(std::filesystem::path(destination) / checkpoint_file))
    if (const auto marker = ResultMarker::lock(destination); marker && marker->owns(destination, checkpoint_file))
      std::filesystem::remove(std::filesystem::path(destination) / checkpoint_file);
  return true;
}

}  // namespace momentree::io
