#include <momentree/results/report/page.hpp>

#include <momentree/base/check.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

/// Replaces the content of the page's JSON element with that id.
std::string with_data(std::string_view page, std::string_view id, std::string_view data) {
  const std::string begin = "<script type=\"application/json\" id=\"" + std::string(id) + "\">";
  const std::size_t at = page.find(begin);
  const std::size_t end = at == std::string_view::npos ? at : page.find("</script>", at);
  MT_REQUIRE(end != std::string_view::npos, "a page with a place for data");
  std::string whole;
  whole.reserve(page.size() + data.size());
  whole += page.substr(0, at + begin.size());
  whole += data;
  whole += page.substr(end);
  return whole;
}

}  // namespace

std::string json_for_page(std::string_view json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json)  // '<' occurs only in strings
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  return safe;
}

std::string report_page(std::string_view page, std::string_view data) { return with_data(page, "recording", data); }

std::string sweep_page(std::string_view page, std::string_view document) {
  return with_data(page, "sweep", json_for_page(document));
}

namespace {

std::string with_meshes(std::string_view key, std::string_view text, std::string_view meshes) {
  std::string json;
  JsonWriter(json).begin_object().member(key, text).end_object();
  if (!meshes.empty()) {
    json.pop_back();
    json += ", \"meshes\": " + std::string(meshes) + "}";
  }
  return json_for_page(json);
}

}  // namespace

std::string playground_page(std::string_view page, std::string_view scenario, std::string_view meshes) {
  std::string text;
  JsonWriter(text).value(scenario);
  return with_data(page, "scenario", meshes.empty() ? json_for_page(text) : with_meshes("scenario", scenario, meshes));
}

std::string model_page(std::string_view page, std::string_view model, std::string_view meshes) {
  return with_data(page, "scenario", with_meshes("model", model, meshes));
}

std::string live_page(std::string_view page, std::string_view meshes) {
  const std::string data = meshes.empty() ? "{}" : "{\"meshes\": {\"meshes\": " + std::string(meshes) + "}}";
  return with_data(page, "live", json_for_page(data));
}

std::string content_policy(std::string_view page) {
  constexpr std::string_view begin = "<meta http-equiv=\"Content-Security-Policy\" content=\"";
  const std::size_t at = page.find(begin);
  MT_REQUIRE(at != std::string_view::npos, "a page with a content policy");
  page.remove_prefix(at + begin.size());
  std::string policy(page.substr(0, page.find('"')));
  constexpr std::string_view elsewhere = "connect-src 'self' https:";  // of the playground, for links to scenarios
  if (const std::size_t connect = policy.find(elsewhere); connect != std::string::npos)
    policy.replace(connect, elsewhere.size(), "connect-src 'self'");
  return policy;
}

}  // namespace momentree::io
