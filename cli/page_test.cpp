// The pages in the program have the places into which data are inserted, and a policy that loads nothing from elsewhere.
#include <string>

#include <doctest/doctest.h>

#include <cli/page.hpp>
#include <momentree/results/report/page.hpp>

namespace momentree::cli {
namespace {

bool contains(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

TEST_CASE("the page of a sweep takes its document") {
  const std::string page = io::sweep_page(sweep_html(), "{\"format\": 1, \"columns\": [], \"values\": {}}");
  CHECK(contains(page, "id=\"sweep\">{\"format\": 1, \"columns\": [], \"values\": {}}</script>"));
  CHECK(page.size() < 200'000);
}

TEST_CASE("the pages of a run and of the playground take their data") {
  CHECK(contains(io::report_page(report_html(), "{}"), "id=\"recording\">{}</script>"));
  CHECK(contains(io::playground_page(playground_html(), "format = 1"), "id=\"scenario\">\"format = 1\"</script>"));
}

TEST_CASE("pages load nothing but themselves") {
  for (const std::string_view page : {report_html(), sweep_html(), playground_html()}) {
    const std::string policy = io::content_policy(page);
    CHECK(contains(policy, "default-src 'none'; script-src 'sha256-"));
    CHECK_FALSE(contains(policy, "'unsafe-inline'"));
    CHECK_FALSE(contains(policy, "http"));
  }
}

}  // namespace
}  // namespace momentree::cli
