#pragma once
// The pages built from web/, embedded in the program.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace momentree::io {
struct Scenario;
}

namespace momentree::cli {

/// web/dist/report.html; io::report_page inserts data into it.
std::string_view report_html();
/// web/dist/sweep.html; io::sweep_page inserts a document into it.
std::string_view sweep_html();
/// web/dist/playground.html; io::playground_page and io::model_page insert a scenario into it.
std::string_view playground_html();

/// The report of a result folder. `summary`: the text of summary.json if that is not yet written.
std::string report_of(const std::filesystem::path& folder, const std::string& summary = {});

/// What the playground's page is given.
struct PlaygroundContent {
  std::string text;    ///< the playground's reader, which opens no files, makes the same world from it
  std::string meshes;  ///< JSON: the packed meshes, and their numbers by their names in `text`; empty: there are none
};
/// Throws Error if there is no such text, because the scenario reads state documents. Meshes that cannot be read are reported.
PlaygroundContent playground_content(const io::Scenario& scenario, const std::vector<std::string>& overrides);

}  // namespace momentree::cli
