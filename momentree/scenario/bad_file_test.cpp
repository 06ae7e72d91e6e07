#include <doctest/doctest.h>

#include <momentree/text/toml.hpp>
#include <tests/bad_input.hpp>

using namespace momentree::io::bad_input;

TEST_CASE("broken TOML is refused at its first error") {
  check({
      {"format = 1\n[[mechanism]\n", "s.toml:2:13: error: cannot read this table header: expected ']', saw the end of the line"},
      {"format = 1\ntitle = \"x\n",
       "s.toml:2:11: error: cannot read this string: it does not end on its line; a closing quotation mark is missing"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1,5\ninertia = 1\n",
       "s.toml:6:9: error: cannot read this key-value pair: expected a comment or whitespace, saw ','; use a point as the "
       "decimal sign"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1.0kg\ninertia = 1\n",
       "s.toml:6:11: error: cannot read this floating-point: expected decimal digit, saw 'k'; a number with a unit is a string: "
       "\"1.0 kg\""},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = 1e999\ninertia = 1\n",
       "s.toml:6:13: error: cannot read this number: it is out of range"},
      {one_body + "mass = 2\n",
       "s.toml:8:8: error: cannot read this key-value pair: cannot redefine existing integer 'mass'; it is given twice"},
      {pinned + "damping = 1 \"N m s\"\n",
       "s.toml:10:13: error: there is a quotation mark where no string can begin; strings are quoted as a whole"},
      {"format = 1\ntitle = it's\n",
       "s.toml:2:11: error: there is a quotation mark where no string can begin; strings are quoted as a whole"},
      {"format = 1\ntitle = \"a\"\"b\"\n",
       "s.toml:2:12: error: there is a quotation mark where no string can begin; strings are quoted as a whole"},
      {pinned + "axis = z\n",
       "s.toml:10:8: error: cannot read this value: could not determine value type; a word is a string: write it in quotes"},
      {pinned + "axis = \n",
       "s.toml:10:8: error: cannot read this key-value pair: expected value, saw the end of the line; a value is missing after "
       "'='"},
      {pinned + "axis = [0, 0,\n",
       "s.toml:10:15: error: cannot read this array: encountered end-of-file; a closing ] is missing"},
      {"format = 1\ntitle = \"a\\q\"\n", "s.toml:2:12: error: cannot read this string: unknown escape sequence '\\q'"},
  });
}

TEST_CASE("files that are not text are refused") {
  using namespace std::string_literals;
  const std::string not_utf8 = ": error: the text is not UTF-8; save the file with the encoding UTF-8";
  check({
      {"format = 1\ntitle = \"\xff\"\n", "s.toml:2:10" + not_utf8},
      {"format = 1\n# \xc3", "s.toml:2:3" + not_utf8},              // truncated within a character
      {"format = 1\n# \xc0\xaf", "s.toml:2:3" + not_utf8},          // a slash encoded in two bytes
      {"format = 1\n# \xe0\x80\xaf", "s.toml:2:3" + not_utf8},      // a slash encoded in three bytes
      {"format = 1\n# \xed\xa0\x80", "s.toml:2:3" + not_utf8},      // half of a pair
      {"format = 1\n# \xf4\x90\x80\x80", "s.toml:2:3" + not_utf8},  // beyond Unicode
      {"format = 1\n# \xf0\x8f\xbf\xbf", "s.toml:2:3" + not_utf8},  // too long
      {"\xff\xfe" + "f\0"s, "s.toml:1:1" + not_utf8},               // UTF-16
      {"format = 1\n# \xf4\x80\x80\x80", "s.toml:2:3: error: a character for private use"},
      {"format = 1\n# ä\0"s, "s.toml:2:4: error: a zero byte: this is not text"},
      {"format = 1\ntitle = “x”\n",
       "s.toml:2:9: error: the character '“' is outside of a string; quotation marks are straight: \""},
      {"format = 1\nmasse = [1, Т]\n",
       "s.toml:2:13: error: the character 'Т' is outside of a string; keys and values have plain letters; others must be in "
       "strings"},
  });
}

TEST_CASE("depth is refused, however it is written") {
  std::string keys = "a", arrays = "a = ", nested;
  for (int i = 0; i < 1'000'000; ++i) keys += ".a", arrays += '[', nested += "a = {";
  check({
      {"format = 1\n" + keys + " = 1\n", "s.toml:2:34: error: a key of more than 17 parts"},
      {"format = 1\n[" + keys + "]\n", "s.toml:2:35: error: a key of more than 17 parts"},
      {"format = 1\nx = { " + keys + " = 1 }\n", "s.toml:2:40: error: a key of more than 17 parts"},
  });
  for (const std::string& text : {arrays, nested}) {
    const momentree::io::ReadResult result = momentree::io::read_scenario_text(text, "s.toml");
    CHECK(!result.scenario);
    CHECK(result.diagnostics.size() == 1);
  }
}

TEST_CASE("dots in strings, numbers and comments do not count as depth") {
  const std::string dots(100, '.');
  const auto said_of = [](const std::string& text) { return said(momentree::io::read_scenario_text(text, "s.toml")); };
  CHECK(said_of(pinned + "# " + dots + "\naxis = [0.0, 0.0, 1.0]\n[world]\ngravity = [0.0, 0.0, 1.0] # " + dots + "\n") == "");
  for (const std::string& quotes :
       {"\"\"\"" + dots + "\"\"\"\"\"", "'''\n" + dots + "'''", "\"\\\"" + dots + "\"", "'" + dots + "'"}) {
    CAPTURE(quotes);
    CHECK(said_of("title = " + quotes + "\n" + pinned) == "");
  }
}

TEST_CASE("files that are not scenarios are refused") {
  check({
      {std::string(),
       "s.toml:1:1: warning: the scenario does not state its format; begin it with format = 1\n"
       "s.toml:1:1: error: the scenario has no mechanism; add [[mechanism]] tables"},
      {"\n\n",
       "s.toml:1:1: warning: the scenario does not state its format; begin it with format = 1\n"
       "s.toml:1:1: error: the scenario has no mechanism; add [[mechanism]] tables"},
      {"format = 2\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = "
       "1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:1:10: error: format 2 is not supported by this version; this version reads format 1"},
      {"format = \"1\"\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = "
       "1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:1:10: error: format: expected 1; this version reads format 1"},
      {"format = 1\n[mechanism]\nname = \"m\"\n",
       "s.toml:2:1: error: expected tables [[mechanism]], found a table; write [[mechanism]]: there may be several"},
      {"format = 1\n[[mechanism.body]]\nname = \"m\"\n",
       "s.toml:2:1: error: expected tables [[mechanism]], found a table; write [[mechanism]]: there may be several"},
      {"format = 1\nmechanism = 3\n", "s.toml:2:13: error: expected tables [[mechanism]], found a number"},
      {"format = 1\nmechanism = [1]\n", "s.toml:2:14: error: expected tables [[mechanism]], found a number"},
      {head,
       "s.toml:2:1: error: mechanism 'm' has no bodies; add [[mechanism.body]] tables, a [mechanism.chain] or a "
       "model = \"robot.urdf\""},
      {one_body + "[event]\nat = 1\n",
       "s.toml:8:1: error: expected tables [[event]], found a table; write [[event]]: there may be several"},
  });
}

TEST_CASE("unknown keys are errors, with the nearest known key") {
  check({
      {"tittle = \"x\"\nformat = 1\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = "
       "1\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:1:1: error: unknown key 'tittle' in a scenario; did you mean 'title'?"},
      {pinned + "dampng = 1\n", "s.toml:10:1: error: unknown key 'dampng' in [mechanism.body.joint]; did you mean 'damping'?"},
      {one_body + "colour_of_mass = 3\n[mechanism.body.joint]\nkind = \"revolute\"\n",
       "s.toml:8:1: error: unknown key 'colour_of_mass' in [[mechanism.body]]; known here: name density mass com inertia joint "
       "shape collision belt"},
      {pinned + "[integrate]\nstp = 1\n", "s.toml:11:1: error: unknown key 'stp' in [integrate]; did you mean 'step'?"},
      {pinned + "[world]\ngravitiy = [0, 0, 0]\n",
       "s.toml:11:1: error: unknown key 'gravitiy' in [world]; did you mean 'gravity'?"},
      {pinned + "[output]\nevrey = 1\n", "s.toml:11:1: error: unknown key 'evrey' in [output]; did you mean 'every'?"},
      {head + "roto = \"free\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n",
       "s.toml:4:1: error: unknown key 'roto' in [[mechanism]]; did you mean 'root'?"},
      {chain + "lenght = 1\n", "s.toml:8:1: error: unknown key 'lenght' in [mechanism.chain]; did you mean 'length'?"},
      {pinned + "at = { xyz = [0, 0, 0], quaternion = [1, 0, 0, 0] }\n",
       "s.toml:10:25: error: unknown key 'quaternion' in 'at'; write 'quat', as in quat = [w, x, y, z]"},
  });
}

TEST_CASE("letters of every alphabet are unchanged, in strings and names") {
  const std::string letters = "aß\xc2\x80 Ж\xc2\x85\xe2\x80\xa8שש漢字\xef\xbf\xbd🌳\xf3\xaf\xbf\xbf";
  momentree::io::SyntaxError error;
  const auto document = momentree::io::parse_toml("words = \"\"\"\\\n  " + letters + "\\u0416\"\"\"\n", error);
  REQUIRE(document);
  CHECK(*document->find("words")->value.string() == letters + "Ж");
  check({{pinned + "\"größe\" = 1\n",
          "s.toml:10:1: error: unknown key 'größe' in [mechanism.body.joint]; known here: name parent at child_at kind "
          "axis q v angle position speed damping stiffness rest armature limits friction strength drive"},
         {"format = 1\ntitle = \"Жß\" x\n",
          "s.toml:2:14: error: cannot read this key-value pair: expected a comment or whitespace, saw 'x'"}});
}

TEST_CASE("lines are quoted only from files recognised as scenarios") {
  const auto refused = [](const std::string& text) {
    const momentree::io::ReadResult result = momentree::io::read_scenario_text(text, "s.toml");
    CHECK(!result.scenario);
    return momentree::io::rendered(result.diagnostics);
  };
  const std::string generic = ": error: this is not a scenario: it cannot be read as TOML; a scenario begins with format = 1\n";
  CHECK(refused("root:$6$secret:19000:0:99999:7:::\ndaemon:*:\n") == "s.toml:1:5" + generic);
  CHECK(refused("key = 'a'\nsecret = 12 kg\n").find("s.toml:2:") == 0);
  for (const char* text : {"password=secret\n", "[default]\nkey = \"secret\"\n", "key = 12 secret\n", "secret\n", "\"secret\n",
                           "key = “secret”\n", "#secret\xff", "secret\0", "format = \"%(secret)s\"\nx\n",
                           "[formatters]\nkey = secret\n", "formats = 1\nkey = secret\n", "mechanisms = secret\n"}) {
    CAPTURE(text);
    CHECK(refused(text).find("secret") == std::string::npos);
  }
  CHECK(refused("#" + std::string(1u << 20, 'x') + "\n[a]\n") ==
        "s.toml: error: this is not a scenario: no line states the format, and none begins a mechanism; a scenario begins with "
        "format "
        "= 1\n");
  // A file with such a line is quoted, wherever the error is.
  for (const char* text :
       {"format = 1\nsecret\n", "secret\nformat=1\n", "\xEF\xBB\xBF format\t= '1'\nsecret\n", "secret\n[[mechanism]]\n",
        "secret\n [ mechanism.chain ]\n", "secret\nmechanism = []\n", "secret\nformat 1\n"}) {
    CAPTURE(text);
    CHECK(refused(text).find(" | secret") != std::string::npos);
  }
}

TEST_CASE("a title is one visible line") {
  check({
      {"format = 1\ntitle = \"a\\u001b[31mb\"\n" + one_body.substr(11),
       "s.toml:2:9: error: title: 'a\\x1b[31mb' has an invisible character; a title is one line without control "
       "characters"},
      {"format = 1\ntitle = \"\"\"a\nb\"\"\"\n" + one_body.substr(11),
       "s.toml:2:9: error: title: 'a\\nb' has an invisible character; a title is one line without control characters"},
  });
}
