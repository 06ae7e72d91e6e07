#include <doctest/doctest.h>

#include <momentree/text/diagnostic.hpp>
#include <momentree/text/diagnostic_json.hpp>

using namespace momentree;
using namespace momentree::io;

TEST_CASE("a diagnostic shows the line and a caret under the character") {
  Diagnostics out("s.toml", "first\n\tä = \"ö\" # x\r\nlast");
  out.error({2, 6, 0}, "it is wrong", "mend it");
  const auto all = out.take();
  REQUIRE(all.size() == 1);
  CHECK(all[0].message() == "s.toml:2:6: error: it is wrong; mend it");
  CHECK(all[0].rendered() == "s.toml:2:6: error: it is wrong; mend it\n    2 | \tä = \"ö\" # x\n      | \t    ^\n");
}

TEST_CASE("a place at the end of a line, after the last line, or nowhere") {
  Diagnostics out("s.toml", "ab\n");
  out.error({1, 3, 0}, "end");
  out.error({9, 1, 0}, "after");
  out.warning({0, 0, 0}, "nowhere");
  const auto all = out.take();
  CHECK(rendered(all) == "s.toml: warning: nowhere\ns.toml:1:3: error: end\n    1 | ab\n      |   ^\ns.toml:9:1: error: after\n");
  CHECK(has_errors(all));
  CHECK(!has_errors({all[0]}));
}

TEST_CASE("lines far down in a file are found, whatever their number") {
  std::string text;
  for (int line = 1; line <= 1000; ++line) text += "line " + std::to_string(line) + "\n";
  for (const int line : {1, 63, 64, 65, 66, 128, 129, 130, 999, 1000}) {
    Diagnostics out("f", text);
    out.error({line, 1, 0}, "x");
    CHECK(out.take().at(0).source == "line " + std::to_string(line));
  }
  Diagnostics out("f", text);
  out.error({1002, 1, 0}, "x");
  CHECK(out.take().at(0).source.empty());
}

TEST_CASE("problems are in the order of the file, options last, at most a hundred of each kind") {
  Diagnostics out("s.toml", "", {"a=1"});
  out.error({0, 0, 1}, "option");
  for (int line = 150; line > 0; --line) out.error({line, 1, 0}, "e" + std::to_string(line));
  const auto all = out.take();
  REQUIRE(all.size() == 101);
  CHECK(all[0].line == 52);
  CHECK(all[98].line == 150);
  CHECK(all[99].message() == "--set a=1: error: option");
  CHECK(all[100].message() == "s.toml: error: and 51 or more further errors");
}

TEST_CASE("more than three equal problems are one, at the first place and with their count") {
  for (const bool downwards : {false, true}) {
    Diagnostics out("s.toml", "a\nb\nc\nd\n");
    out.error({2, 5, 0}, "other");
    for (int i = 0; i < 1000; ++i) out.error({downwards ? 1003 - i : 4 + i, 1, 0}, "it is wrong", "mend it");
    for (int line = 1; line <= 3; ++line) out.error({line, 2, 0}, "it is odd");
    for (int line = 1; line <= 4; ++line) out.warning({line, 3, 0}, "it is wrong", "mend it");
    CHECK(out.errors() == 1004);
    CHECK(!out.full());
    const auto all = out.take();
    REQUIRE(all.size() == 6);
    CHECK(all[1].message() == "s.toml:1:3: warning: it is wrong (and 3 times more, up to line 4); mend it");
    CHECK(all[4].message() == "s.toml:3:2: error: it is odd");
    CHECK(all[5].message() == "s.toml:4:1: error: it is wrong (and 999 times more, up to line 1003); mend it");
    CHECK(all[5].source == "d");
  }
}

TEST_CASE("a terminal gets no control characters, and no endless lines") {
  const std::string source = "\x1b[31m" + std::string(1000, 'x');  // Diagnostics stores a view of it
  Diagnostics out("s\x1b.toml", source);
  out.error({1, 1, 0}, "a\nb", "c\x07");
  const std::string text = rendered(out.take());
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK(text.find('\x07') == std::string::npos);
  CHECK(text.find("s\\x1b.toml:1:1: error: a\\nb; c\\x07\n    1 | \\x1b[31mxxx") == 0);
  CHECK(text.size() < 300);
  CHECK(in_quotes("ö\n" + std::string(100, 'x')) == "'ö\\n" + std::string(58, 'x') + "…'");
}

TEST_CASE("the caret is below its character, whatever comes before it") {
  Diagnostics out("s.toml", "\tö\x1b\xC2\x9B\xFF\xE2\x80\xAEx = 1");
  out.error({1, 7, 0}, "e");
  CHECK(out.take().at(0).rendered() ==
        "s.toml:1:7: error: e\n    1 | \tö\\x1b\\u009b\xEF\xBF\xBD\\u202ex = 1\n"
        "      | \t                  ^\n");
}

TEST_CASE("where a problem ends: after the key, the string, the list, the tag at that place") {
  CHECK(end_column("kind = \"revolut\"  # no", 8) == 17);
  CHECK(end_column("kind = \"rev\\\"olut\"", 8) == 19);
  CHECK(end_column("  mass = -1.5e3", 3) == 7);
  CHECK(end_column("  mass = -1.5e3", 10) == 16);
  CHECK(end_column("axis = [0, \"]\", [1]]", 8) == 21);
  CHECK(end_column("at = { xyz = [0, 0, 0] }", 6) == 25);
  CHECK(end_column("<link name='ä'>", 1) == 6);
  CHECK(end_column("<link name='ä'>", 12) == 15);  // characters, not bytes
  CHECK(end_column("shape = [", 9) == 0);          // it ends on another line
  CHECK(end_column("name = \"open", 8) == 0);
  CHECK(end_column("a = 1", 0) == 0);
  CHECK(end_column("a = 1", 6) == 0);
  CHECK(end_column("", 1) == 0);
}

TEST_CASE("a problem as JSON: unknown values are null") {
  std::string text;
  JsonWriter json(text);
  write_diagnostic(json, {Severity::warning, "s.toml", 3, 8, "odd", "", "kind = \"x\""});
  CHECK(text == R"({"severity": "warning", "message": "odd", "hint": null, "file": "s.toml", "line": 3, "column": 8, )"
                R"("end_line": 3, "end_column": 11})");
  text.clear();
  JsonWriter other(text);
  write_diagnostic(other, {Severity::error, "s.toml", 0, 0, "is missing", "make it", ""});
  CHECK(text ==
        R"({"severity": "error", "message": "is missing", "hint": "make it", "file": "s.toml", "line": null, "column": null, )"
        R"("end_line": null, "end_column": null})");
}
