#include <cli/input.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <new>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

std::string read_standard_input() {
  constexpr std::size_t largest = 256u << 20, piece = 1u << 16;
  std::string text;
  for (std::size_t got = piece; got == piece;) {
    const std::size_t size = text.size();
    text.resize(size + piece);
    got = std::fread(text.data() + size, 1, piece, stdin);
    text.resize(size + got);
    if (text.size() > largest) throw_error({"is larger than 256 MiB", standard_input, ""});
  }
  if (std::ferror(stdin) != 0) throw_error({std::string("cannot be read: ") + std::strerror(errno), standard_input, ""});
  return text;
}

io::ReadResult read_input(const std::string& path, const std::vector<std::string>& overrides) {
  try {
    if (!is_standard_input(path)) return io::read_scenario(path, overrides);
    return io::read_scenario_from(read_standard_input(), standard_input, "stdin", "", overrides);
  } catch (const std::bad_alloc&) {
    throw_error({"not enough free memory to read it", path, "about 3 kB are needed for each body"});
  }
}

void count_notes(io::ReadResult& result) {
  std::map<std::string, long> counted;
  const auto of_model = [&](const io::Diagnostic& d) {
    return d.severity == io::Severity::note && std::ranges::count(result.model_files, d.file) > 0;
  };
  for (const io::Diagnostic& each : result.diagnostics)
    if (of_model(each)) ++counted[each.file];
  std::erase_if(result.diagnostics, of_model);
  for (const auto& [file, count] : counted)
    result.diagnostics.push_back({io::Severity::note, file, 0, 0,
                                  count_text(count, "note on this model is", "notes on this model are") + " not shown",
                                  count == 1 ? "-v shows it" : "-v lists them", ""});
}

std::shared_ptr<const io::Scenario> load(const std::string& path, const std::vector<std::string>& overrides, Notes notes,
                                         io::Severity least) {
  io::ReadResult result = read_input(path, overrides);
  if (notes == Notes::counted) count_notes(result);
  std::erase_if(result.diagnostics, [least](const io::Diagnostic& d) { return d.severity > least; });
  show(stderr, io::rendered(result.diagnostics));
  return result.scenario ? std::make_shared<const io::Scenario>(std::move(*result.scenario)) : nullptr;
}

void refuse_to_overwrite(const std::string& out, const io::Scenario& scenario) {
  namespace fs = std::filesystem;
  const auto refuse = [&out](const fs::path& source) {
    std::error_code ignored;
    if (fs::equivalent(out, source, ignored))
      throw_error({"this is an input file: it would be overwritten", out, "give the output another name"});
  };
  if (out == "-") return;
  refuse(scenario.path);
  for (const io::StateFile& state : scenario.state_files) refuse(state.file);
  const Value::Entry* const mechanisms = scenario.document->find("mechanism");
  if (mechanisms == nullptr || mechanisms->value.array() == nullptr) return;
  for (const Value& mechanism : *mechanisms->value.array())
    if (const Value::Entry* model = mechanism.find("model"); model != nullptr && model->value.string() != nullptr)
      refuse(fs::path(scenario.path).parent_path() / *model->value.string());
}

std::vector<io::RestoredState> documents_of(const std::string& state, const Model& model) {
  if (state.empty()) return {};
  const bool piped = is_standard_input(state);
  return {io::read_state(piped ? read_standard_input() : io::read_text_file(state), piped ? standard_input : state, model)};
}

}  // namespace momentree::cli
