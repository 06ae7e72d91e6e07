#include <momentree/io/json_document.hpp>

#include <doctest/doctest.h>

#include <momentree/io/test_support.hpp>

namespace momentree::io {
namespace {

std::string mistake(const std::string& text) {
  return test::error_of([&] { parse_json(text, "f.json"); });
}

TEST_CASE("nodes have their places") {
  const JsonDocument d = parse_json("{ \"a\": 1,\n  \"b\": [true,\n        \"x\", 2.5\n  ] }", "f.json");
  CHECK(d.where(d.root) == "f.json:1:1");
  CHECK(d.where(*d.root.find("a")) == "f.json:1:3");
  const JsonNode& b = *d.root.find("b");
  CHECK(d.where(b) == "f.json:2:3");
  CHECK(d.where(b.items[0]) == "f.json:2:9");
  CHECK(d.where(b.items[1]) == "f.json:3:9");
  CHECK(b.items[2].line == 3);  // a number at the end of a line belongs to that line
  CHECK(b.items[2].number == 2.5);
  CHECK(d.root.find("c") == nullptr);
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

TEST_CASE("values must have the requested types, and keys must be known") {
  const JsonDocument d = parse_json(R"({"n": 1, "s": "x", "a": [1, "y"]})", "f.json");
  CHECK(d.number(*d.root.find("n"), "n") == 1);
  CHECK(test::error_of([&] { d.number(*d.root.find("s"), "`s`"); }) ==
        "f.json:1:10: error: `s` should be a number, not a string");
  CHECK(test::error_of([&] { d.numbers(*d.root.find("a"), "`a`"); }).find("each item of `a` should be a number") !=
        std::string::npos);
  CHECK(test::error_of([&] { d.require_known(d.root, {"n", "s", "angle"}); }) == "f.json:1:20: error: unknown key \"a\"");
  CHECK(test::error_of([&] {
          d.require_known(parse_json("{\"joint\": 1}", "f.json").root, {"joints"});
        }).find("did you mean 'joints'?") != std::string::npos);
}

}  // namespace
}  // namespace momentree::io
