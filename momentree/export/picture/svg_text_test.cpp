#include <momentree/export/picture/svg_text.hpp>

#include <set>

#include <doctest/doctest.h>

namespace momentree::io {

TEST_CASE("any text becomes well-formed XML") {
  CHECK(xml_escaped("a<b> & \"c\" 'd'") == "a&lt;b&gt; &amp; &quot;c&quot; &apos;d&apos;");
  CHECK(xml_escaped("Gr\xC3\xB6\xC3\x9F"
                    "e \xE2\x86\x92 \xF0\x9F\x99\x82") ==
        "Gr\xC3\xB6\xC3\x9F"
        "e \xE2\x86\x92 \xF0\x9F\x99\x82");
  const std::string unknown = "\xEF\xBF\xBD";
  CHECK(xml_escaped(std::string_view("a\0b\x1B", 4)) == "a" + unknown + "b" + unknown);
  CHECK(xml_escaped("\xC3") == unknown);
  CHECK(xml_escaped("\xC0\xAF") == unknown + unknown);                // an overlong '/'
  CHECK(xml_escaped("\xED\xA0\x80") == unknown + unknown + unknown);  // a surrogate
}

TEST_CASE("pixels are rounded to a tenth and written short") {
  CHECK(pixels(12.34) == "12.3");
  CHECK(pixels(7.0) == "7");
  CHECK(pixels(-0.04) == "0");
  CHECK(pixels(0.1 + 0.2) == "0.3");
  CHECK(pixels(1e300) == "10000000");
  CHECK(pixels(Point2{1.26, -2}) == "1.3 -2");
}

TEST_CASE("numbers are written as people write them") {
  CHECK(plain_number(0.2 * 9) == "1.8");
  CHECK(plain_number(-1e-17) == "0");
  CHECK(plain_number(3) == "3");
}

TEST_CASE("times of frames have the decimals of the time between them") {
  CHECK(frame_time(1, 0.2) == "1.0");
  CHECK(frame_time(0.2 * 9, 0.2) == "1.8");
  CHECK(frame_time(0, 0.25) == "0.00");
  CHECK(frame_time(5, 5) == "5");
  CHECK(frame_time(0.123, 0.2) == "0.123");
}

TEST_CASE("eight mechanisms have eight colours") {
  std::set<std::string> colours;
  for (std::size_t n = 0; n < 8; ++n) colours.insert(mechanism_colour(n));
  CHECK(colours.size() == 8);
  CHECK(mechanism_colour(8) == mechanism_colour(0));
}

TEST_CASE("a tint lies between white and the colour") {
  CHECK(tint("#204060", 1) == "#204060");
  CHECK(tint("#204060", 0) == "#ffffff");
  CHECK(tint("#000000", 0.5) == "#808080");
  CHECK(tint("red", 0.5) == "red");
  CHECK(tint("#zzzzzz", 0.5) == "#zzzzzz");
}

TEST_CASE("a colour that could break out of its attribute is not used") {
  CHECK(safe_colour("#ff8800", "red") == "#ff8800");
  CHECK(safe_colour("orange", "red") == "orange");
  CHECK(safe_colour("\" onload=\"alert(1)", "red") == "red");
  CHECK(safe_colour("", "red") == "red");
}

}  // namespace momentree::io
