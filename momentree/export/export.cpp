#include <momentree/export/export.hpp>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/export/exporter.hpp>
#include <momentree/text/files/file_name.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

namespace {

/// Sorted by name, but those for the same programs follow one another.
std::vector<Exporter> all_exporters() {
  std::vector<Exporter> all;
#define MOMENTREE_EXPORTER(name, Type) exporters::name(),
  for (const Exporter& each : {MOMENTREE_EXPORTERS(MOMENTREE_EXPORTER)}) {
#undef MOMENTREE_EXPORTER
    const auto same = [&](const Exporter& other) { return std::string_view(other.readers) == each.readers; };
    const auto last = std::find_if(all.rbegin(), all.rend(), same);
    all.insert(last == all.rend() ? all.end() : last.base(), each);
  }
  return all;
}

std::optional<Exporter> exporter_of(const std::filesystem::path& file) {
  for (const Exporter& each : all_exporters())
    if (small_ending(file.native()) == each.ending) return each;
  return std::nullopt;
}

/// "a, b or c"
std::string alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " or ") + words[i];
  return text;
}

/// "in .glb (glTF) or .usda (USD), for 3D programs, or in .mcap (for Foxglove)"
std::string endings_by_readers() {
  const std::vector<Exporter> all = all_exporters();
  std::string text;
  for (auto first = all.begin(), next = first; first != all.end(); first = next) {
    next = std::find_if(first, all.end(), [&](const Exporter& e) { return std::string_view(e.readers) != first->readers; });
    const std::string readers = std::string("for ") + first->readers;
    const bool alone = next - first == 1;
    std::vector<std::string> endings;
    for (auto each = first; each != next; ++each)
      endings.push_back(std::string(each->ending) + " (" + (alone ? readers : each->format) + ')');
    text += (text.empty() ? "in " : next == all.end() ? ", or in " : ", in ") + alternatives(endings);
    if (!alone) text += ", " + readers;
  }
  return text;
}

}  // namespace

std::string export_formats() {
  std::vector<std::string> words;
  for (const Exporter& each : all_exporters()) words.push_back(std::string(each.ending) + " (" + each.content + ')');
  return alternatives(words);
}

void require_export_name(const std::filesystem::path& file) {
  if (exporter_of(file)) return;
  const std::string ending = small_ending(file.native());
  throw_error({ending.empty() ? "the name has no ending, which says the format" : "runs cannot be exported as '" + ending + "'",
               file.string(), "name a file that ends " + endings_by_readers()});
}

void export_result(const std::filesystem::path& directory, const std::filesystem::path& file) {
  require_export_name(file);
  write_text_file(file.string(), exporter_of(file)->bytes(read_drawing(directory)));
}

}  // namespace momentree::io
