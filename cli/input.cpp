#include <cli/input.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <new>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>

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

}  // namespace momentree::cli
