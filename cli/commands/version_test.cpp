// What --version and -V say, against what this test is compiled with: the same compiler and configuration.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cli/commands/version.hpp>
#include <momentree/base/build_info.hpp>
#include <momentree/batch/stepper.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/program.hpp>

namespace momentree {
namespace {

using namespace test;

std::string number(int part) { return std::to_string(part); }

TEST_CASE("the version says how the program was built") {
  const Workplace here;
  const std::string version =
      number(MOMENTREE_VERSION_MAJOR) + "." + number(MOMENTREE_VERSION_MINOR) + "." + number(MOMENTREE_VERSION_PATCH);
  CHECK(build_info().version == version);
  const Outcome brief = here.call("--version"), full = here.call("-V");
  CHECK(brief.code == 0);
  CHECK(full.code == 0);
  CHECK(brief.output.starts_with("momentree " + version + "\n"));
  CHECK(full.output.starts_with("momentree " + version + "\n"));
  CHECK(std::ranges::count(brief.output, '\n') == 2);
#ifndef __clang__
  const std::string compiler = "GCC " + number(__GNUC__) + "." + number(__GNUC_MINOR__) + "." + number(__GNUC_PATCHLEVEL__);
  CHECK(brief.says((compiler + ", ").c_str()));
  CHECK(full.says(("compiler        " + compiler + "\n").c_str()));
#endif
#ifdef __AVX512F__
  CHECK(build_info().instructions == "x86-64 with AVX-512");
  CHECK(full.says("-march="));
#endif
  CHECK(full.says("-ffp-contract=off"));
  const std::pair<Isa, const char*> sets[] = {{Isa::baseline, "baseline"}, {Isa::avx2, "avx2"}, {Isa::avx512, "avx512"}};
  for (const auto& [isa, name] : sets)
    if (batch::available(isa)) CHECK(build_info().lanes.find(name) != std::string_view::npos);
}

TEST_CASE("the commit is there if it is known") {
  const std::string commit = "0123456789abcdef0123456789abcdef01234567";
  CHECK(cli::version_text(commit).ends_with(", commit 0123456789ab\n"));
  CHECK(cli::version_text(commit + " with changes").ends_with(", commit 0123456789ab with changes\n"));
  CHECK(cli::version_text("").find("commit") == std::string::npos);
  CHECK(cli::long_version_text(commit).find("\ncommit          " + commit + "\n") != std::string::npos);
  CHECK(cli::long_version_text("").find("\ncommit          unknown\n") != std::string::npos);
}

}  // namespace
}  // namespace momentree
