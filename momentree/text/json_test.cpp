#include <momentree/text/json.hpp>

#include <doctest/doctest.h>

#include <momentree/scenario/test_support.hpp>

namespace momentree::io {
namespace {

std::string mistake(const std::string& text) {
  return test::error_of([&] { parse_json(text, "f.json"); });
}

TEST_CASE("keys and values have their places") {
  const Value root = parse_json("{ \"ä\": 1,\n  \"b\" : [true,\n        \"\\u0041\", -2.5\n  , null], \"c\":{}}", "f.json");
  const auto at = [](Place place, int line, int column) { return place.line == line && place.column == column; };
  CHECK(at(root.place, 1, 1));
  CHECK(at(root.find("ä")->place, 1, 3));
  CHECK(at(root.find("ä")->value.place, 1, 8));  // columns count characters
  CHECK(*root.find("ä")->value.integer() == 1);
  CHECK(at(root.find("b")->place, 2, 3));
  const Value::Array& b = *root.find("b")->value.array();
  CHECK(at(root.find("b")->value.place, 2, 9));
  CHECK(at(b[0].place, 2, 10));
  CHECK(*b[0].boolean());
  CHECK(at(b[1].place, 3, 9));
  CHECK(*b[1].string() == "A");
  CHECK(at(b[2].place, 3, 19));
  CHECK(*b[2].real() == -2.5);
  CHECK(at(b[3].place, 4, 5));
  CHECK(b[3].is_null());
  CHECK(at(root.find("c")->value.place, 4, 16));
  CHECK(root.find("d") == nullptr);
  CHECK(*parse_json("18446744073709551615", "f.json").real() == 18446744073709551615.0);
}

TEST_CASE("broken JSON is refused with its place") {
  CHECK(mistake("{ \"a\": 1,\n  b: 2 }").starts_with("f.json:2:3: error: this is not JSON"));
  CHECK(mistake("").starts_with("f.json:1:1: error: this is not JSON"));
  CHECK(mistake("[1, 2").starts_with("f.json:1:"));
  CHECK(mistake("[1] [2]").starts_with("f.json:1:5"));
  CHECK(mistake("[NaN]").starts_with("f.json:1:"));
  CHECK(mistake("[1e999]").ends_with("this is not JSON: a number is out of range"));
  CHECK(mistake("[\"\xff\"]").starts_with("f.json:1:"));
  CHECK(mistake("{\"a\": 1, \"a\": 2}") == "f.json:1:10: error: the key \"a\" is given twice");
  CHECK(mistake(std::string(1000000, '[')).find("nested deeper than 64") != std::string::npos);
  CHECK(mistake(std::string("[1]\0", 4)).starts_with("f.json:1:4: error"));
}

TEST_CASE("files that are not JSON are not quoted") {
  for (const char* text :
       {"root:$6$secret:19000::", "secret", "{ \"a\": secret }", "{ \"secret\n\" }", "[1secret]", "{ \"a\" \"secret\" }"}) {
    CAPTURE(text);
    const std::string message = mistake(text);
    CHECK(message.starts_with("f.json:1:"));
    CHECK(message.find("secret") == std::string::npos);
  }
  CHECK(mistake("{ \"a\": 1,, }").ends_with("syntax error while parsing object key - unexpected ','; expected string literal"));
}

}  // namespace
}  // namespace momentree::io
