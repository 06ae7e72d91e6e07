#pragma once
// The pages of web/ with the data that they show: each is a single self-contained file.
#include <string>
#include <string_view>

namespace momentree::io {

/// JSON that can be embedded in a page: no string in it can close the enclosing element.
std::string json_for_page(std::string_view json);

/// The report's page with the data of a run (report_data).
std::string report_page(std::string_view page, std::string_view data);

/// The page of a sweep with its document, which is JSON (web/src/sweep/document.ts).
std::string sweep_page(std::string_view page, std::string_view document);

/// The playground's page, which begins with the text of a scenario. `meshes`: JSON (web/src/meshes.ts); empty: none.
std::string playground_page(std::string_view page, std::string_view scenario, std::string_view meshes = {});

/// The playground's page with sliders for the joints of a model, which is given as the text of a scenario.
std::string model_page(std::string_view page, std::string_view model, std::string_view meshes = {});

/// The page of a live view. `meshes`: a JSON list (PackedMeshes::json); empty: none.
std::string live_page(std::string_view page, std::string_view meshes = {});

/// The content security policy stated in the page itself, for a server that sends it. Unlike the file, a served page may not load
/// scenarios from other addresses.
std::string content_policy(std::string_view page);

}  // namespace momentree::io
