#include <momentree/results/compare/compare.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/results/compare/parts.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

namespace {

void require_result(const std::filesystem::path& folder) {
  const char* const give = "give a folder that `momentree run` wrote";
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    const std::string partial = folder.string() + ".partial";
    throw_error({"there is no such folder", folder.string(),
                 std::filesystem::is_directory(partial, ignored) ? "its run did not end: give " + partial : give});
  }
  for (const char* const file : {"bodies.csv", "joints.csv", "events.jsonl"})
    if (!is_there(folder / file)) throw_error({"this folder has no " + std::string(file), folder.string(), give});
}

}  // namespace

Comparison compare_results(const std::string& one, const std::string& other, double tolerance) {
  const Compared folders{one, other, tolerance};
  require_result(folders.one);
  require_result(folders.other);
  Comparison all;
  std::vector<Difference>& found = all.differences;
  compare_documents(folders, "model.json", "title", found);
  for (Difference& difference : found) difference.kind = Difference::Kind::model;
  const TableEnds ends = compare_tables(folders, "bodies.csv", found);
  compare_tables(folders, "joints.csv", found);
  for (const char* const file : {"springs.csv", "contacts.csv"})
    if (is_there(folders.one / file) && is_there(folders.other / file)) compare_tables(folders, file, found);
  all.rows = ends.rows;
  all.events = compare_events(folders, ends, found);
  const bool same_length = std::ranges::none_of(found, [](const Difference& d) { return d.kind == Difference::Kind::longer; });
  if (same_length) compare_documents(folders, "final.json", "", found);
  const auto place = [](const Difference& d) {
    return d.kind == Difference::Kind::model ? -HUGE_VAL : d.time.value_or(HUGE_VAL);
  };
  std::ranges::stable_sort(found, [&](const Difference& a, const Difference& b) { return place(a) < place(b); });
  return all;
}

}  // namespace momentree::io
