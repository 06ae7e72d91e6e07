#include <momentree/models/xml/document.hpp>

#include <string>

#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>

namespace momentree::io {
namespace {

std::string at(Place place) { return std::to_string(place.line) + ":" + std::to_string(place.column); }

std::string refused(const std::string& text) {
  SyntaxError error;
  CHECK(XmlDocument::parse(text, error) == nullptr);
  return at(error.place) + ": " + error.what + (error.hint.empty() ? "" : "; " + error.hint);
}

}  // namespace

TEST_CASE("elements, attributes and texts have their places") {
  const std::string text =
      "\xEF\xBB\xBF<?xml version=\"1.0\"?>\r\n<!-- <no/> -->\r\n<robot\tname = 'ä &lt; b'\r\n       kind=\"x\">\r\n"
      "  <a/> <b c=\"1\"\td=\"2\"> öne &amp; two <e/> three</b>\r\n</robot>\r\n";
  SyntaxError error;
  const auto document = XmlDocument::parse(text, error);
  REQUIRE(document);
  const XmlElement root = document->root();
  CHECK(root.name() == "robot");
  CHECK(at(root.place()) == "3:1");
  REQUIRE(root.attributes() == 2);
  CHECK(root.attribute_name(0) == "name");
  CHECK(root.attribute(0) == "ä < b");
  CHECK(at(root.attribute_place(0)) == "3:16");
  CHECK(at(root.attribute_place(0, false)) == "3:8");
  CHECK(at(root.attribute_place(1)) == "4:14");
  CHECK(root.find("kind") == 1u);
  CHECK(!root.find("none"));
  const XmlElement a = root.first_child(), b = a.next();
  CHECK(a.name() == "a");
  CHECK(at(b.place()) == "5:8");
  CHECK(at(b.attribute_place(1)) == "5:20");
  CHECK(b.text() == "öne & two");
  CHECK(at(b.text_place()) == "5:24");
  CHECK(b.first_child().name() == "e");
  CHECK(b.first_child().parent() == b);
  CHECK(!b.next());
  CHECK(!root.parent());
  int count = 0;
  for (const XmlElement child : root.children()) count += child.name().size() == 1 ? 1 : 0;
  CHECK(count == 2);
}

TEST_CASE("invalid XML is refused at its first error") {
  using namespace std::string_literals;
  CHECK(refused("") == "1:1: the file is empty: there is no element in it");
  CHECK(refused("<?xml version=\"1.0\"?>\n<!-- -->") == "2:9: the file is empty: there is no element in it");
  CHECK(refused("<a>\n  <b>\n") == "3:1: the file ends within <b>, opened on line 2; is it complete?");
  CHECK(refused("<a>\n  <b") == "2:3: the file ends within <a>, opened on line 1; is it complete?");
  CHECK(refused("<a><b></a></b>") ==
        "1:9: this tag does not close <b>, opened on line 1; every element is closed before the one that holds it");
  CHECK(refused("<a/>\n<b/>") == "2:1: something follows the end of the document; a file holds one root element");
  CHECK(refused("<a x='1' x='2'/>") == "1:10: an attribute is given twice in this tag");
  CHECK(refused("<a>&bomb;</a>") == "1:4: an entity that XML does not define; XML defines &lt; &gt; &amp; &quot; and &apos;");
  CHECK(refused("\n<?xml version=\"1.0\"?><a/>") ==
        "2:1: <?xml …?> is allowed only at the very beginning of a file; remove what is before it");
  CHECK(refused("mass = 1\n") == "1:1: cannot read this as XML: syntax error; this file contains no tags");
  CHECK(refused("<a b=1/>").starts_with("1:6: cannot read this as XML: not well-formed"));
  CHECK(refused("<a>\xff</a>") == "1:4: the text is not UTF-8; save the file with the encoding UTF-8");
  CHECK(refused("<a>\n\0</a>"s) == "2:1: a zero byte: this is not text");
  CHECK(refused("\xff\xfe<\0a\0/\0>\0"s).starts_with("1:1: the text is not UTF-8"));
}

TEST_CASE("no entity is declared, expanded or fetched") {
  const std::string said =
      ": a document type (<!DOCTYPE …>) is not supported: no entity is declared, expanded or fetched; leave it out: a model "
      "needs "
      "none";
  std::string bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE r [\n<!ENTITY a0 \"ha\">\n";
  for (int i = 1; i < 30; ++i)
    bomb += "<!ENTITY a" + std::to_string(i) + " \"&a" + std::to_string(i - 1) + ";&a" + std::to_string(i - 1) + ";\">\n";
  CHECK(refused(bomb + "]>\n<r>&a29;</r>") == "2:1" + said);
  CHECK(refused("<!DOCTYPE r [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><r>&x;</r>") == "1:1" + said);
  CHECK(refused("<!DOCTYPE r SYSTEM \"http://127.0.0.1/r.dtd\"><r/>") == "1:1" + said);
}

TEST_CASE("depth and numbers are bounded, time is linear") {
  std::string deep, wide = "<a>";
  for (int i = 0; i < 1'000'000; ++i) deep += "<a>";
  CHECK(refused(deep) == "1:3001: elements are nested more than 1000 deep; no model needs that");
  while (wide.size() < 10'000'000) wide += "<b/>";
  CHECK(refused(wide + "</a>") == "1:8000000: more than 2000000 elements; no model is as large as that");
}

TEST_CASE("places are right for lines of any length and at the boundaries of blocks") {
  std::string text = "\xEF\xBB\xBF<r>";
  for (int k = 0; k < 3000; ++k) {
    text += k % 7 == 3 ? "\n" : k % 5 == 1 ? "ä" : "  ";
    text += "<e a='" + std::string(static_cast<std::size_t>(k % 11), 'x') + "'/>";
  }
  text += "</r>";
  SyntaxError error;
  const auto document = XmlDocument::parse(text, error);
  REQUIRE(document);
  // Positions counted independently.
  int line = 1, column = 1;
  std::vector<Place> expected;
  for (std::size_t i = 3; i < text.size(); ++i) {
    if (text.compare(i, 2, "<e") == 0) expected.push_back({line, column, 0});
    if (text[i] == '\n')
      ++line, column = 1;
    else if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80)
      ++column;
  }
  std::size_t k = 0;
  for (const XmlElement element : document->root().children()) {
    REQUIRE(k < expected.size());
    CHECK(element.place() == expected[k++]);
  }
  CHECK(k == 3000);
}

TEST_CASE("a file with every name and number wrong is checked quickly, even on one line") {
  std::string text = "<robot name='r'>";
  for (int k = 0; k < 20'000; ++k)
    text += "<link name='l" + std::to_string(k) + "'><inertial><mass value='1'/></inertial><unheard" + std::to_string(k) +
            "/></link>";
  const ReadResult result = read_scenario_text(text + "</robot>", "r.urdf");
  CHECK(!result.scenario);  // several roots
  CHECK(has_errors(result.diagnostics));
}

TEST_CASE("the first tag of a text, whatever comes before it") {
  CHECK(first_tag("<robot name='r'>") == "robot");
  CHECK(first_tag("\xEF\xBB\xBF \r\n<?xml version='1.0'?><!-- <a> --> <?x?>\n<sdf>") == "sdf");
  CHECK(first_tag("<a/>") == "a");
  CHECK(first_tag("<robot") == "robot");
  for (const char* text : {"", " ", "x<a>", "<", "<!-- <a>", "<?xml", "<!-->", "<?>", "<!DOCTYPE a>"}) {
    CAPTURE(text);
    CHECK((first_tag(text).empty() || first_tag(text) == "!DOCTYPE"));
  }
}

// An algorithm of quadratic time would take an hour here.
TEST_CASE("elements with a hundred thousand attributes, or children, are read at once") {
  const auto names = [](const std::string& before, const std::string& after) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += before + std::to_string(i) + after;
    return text;
  };
  for (const std::string& text : {"<robot name='r'><link name='l' " + names("a", "='1' ") + "/></robot>",
                                  "<robot name='r'><link name='l'><inertial " + names("xyz", "='1' ") + "/></link></robot>",
                                  "<robot name='r'><link name='l'>" + names("<inertia", "/>") + "</link></robot>",
                                  "<robot name='r'>" + names("<lin", "/>") + "</robot>",
                                  "<mujoco><worldbody><body><joint " + names("a", "='1' ") + "/></body></worldbody></mujoco>",
                                  "<sdf version='1.9'><model name='m' " + names("a", "='1' ") + "/></sdf>"}) {
    const ReadResult result = read_scenario_text(text, "m.xml");
    CHECK(!result.diagnostics.empty());
    CHECK(result.diagnostics.size() < 400);
  }
  CHECK(refused("<r " + names("a", "='1' ") + "b='1'/>") ==
        "1:1: more than 100000 attributes in one element; no model is as large as that");
}

}  // namespace momentree::io
