#include <cli/commands/version.hpp>
#include <momentree/base/build_info.hpp>
#include <momentree/batch/stepper.hpp>

namespace momentree::cli {

namespace {

std::string first_line() { return "momentree " + std::string(build_info().version) + '\n'; }

std::string_view widest_lanes() {
  switch (batch::best_isa()) {
    case Isa::avx512: return "avx512";
    case Isa::avx2: return "avx2";
    case Isa::baseline: break;
  }
  return "baseline";
}

}  // namespace

std::string version_text(std::string_view commit) {
  const BuildInfo& build = build_info();
  std::string text = first_line() + std::string(build.compiler) + ", " + std::string(build.configuration) + ", " +
                     std::string(build.instructions) + ", lanes: " + std::string(build.lanes);
  if (!commit.empty()) {
    const std::size_t rest = commit.find(' ');  // "with changes"
    text += ", commit " + std::string(commit.substr(0, 12));
    if (rest != std::string_view::npos) text += commit.substr(rest);
  }
  return text + '\n';
}

std::string long_version_text(std::string_view commit) {
  const BuildInfo& build = build_info();
  std::string text = first_line();
  const auto line = [&text](std::string_view name, std::string_view value) {
    text += std::string(name) + std::string(16 - name.size(), ' ') + std::string(value) + '\n';
  };
  line("commit", commit.empty() ? "unknown" : commit);
  line("compiler", build.compiler);
  line("configuration", build.configuration);
  line("flags", build.flags);
  line("instructions", build.instructions);
  line("lanes", build.lanes);
  line("lanes used", widest_lanes());
  line("formats", "scenario 1, sweep 1");
  return text;
}

}  // namespace momentree::cli
