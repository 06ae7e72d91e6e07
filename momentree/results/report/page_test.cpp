#include <string>

#include <doctest/doctest.h>

#include <momentree/results/report/page.hpp>

namespace momentree::io {
namespace {

const std::string head = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'\" />";

TEST_CASE("data are inserted into the page's placeholder") {
  const std::string page = head + "<script type=\"application/json\" id=\"recording\"></script>";
  CHECK(content_policy(page) == "default-src 'none'");
  CHECK(report_page(page, "{\"a\": 1}") == head + "<script type=\"application/json\" id=\"recording\">{\"a\": 1}</script>");
}

TEST_CASE("the document of a sweep is inserted into its page, and can't end its element") {
  const std::string page = head + "<script type=\"application/json\" id=\"sweep\"></script></body>";
  CHECK(sweep_page(page, "{\"title\": \"</script>\"}") ==
        head + "<script type=\"application/json\" id=\"sweep\">{\"title\": \"\\u003c/script>\"}</script></body>");
}

TEST_CASE("a scenario replaces what the playground would begin with, and can't end its element") {
  const std::string page = head + "<script type=\"application/json\" id=\"scenario\">\n null\n</script></body>";
  CHECK(playground_page(page, "title = \"</script>\"\n") ==
        head + "<script type=\"application/json\" id=\"scenario\">\"title = \\\"\\u003c/script>\\\"\\u000a\"</script></body>");
  CHECK(model_page(page, "<") ==
        head + "<script type=\"application/json\" id=\"scenario\">{\"model\": \"\\u003c\"}</script></body>");
}

}  // namespace
}  // namespace momentree::io
