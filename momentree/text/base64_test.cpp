#include <momentree/text/base64.hpp>

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <string_view>

namespace momentree::io {
namespace {

std::string encoded(std::string_view bytes) {
  std::string text;
  append_base64(text, {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  return text;
}

TEST_CASE("base64: the test vectors of RFC 4648") {
  CHECK(encoded("") == "");
  CHECK(encoded("f") == "Zg==");
  CHECK(encoded("fo") == "Zm8=");
  CHECK(encoded("foo") == "Zm9v");
  CHECK(encoded("foob") == "Zm9vYg==");
  CHECK(encoded("fooba") == "Zm9vYmE=");
  CHECK(encoded("foobar") == "Zm9vYmFy");
  CHECK(encoded("\xff\xfe\xfd") == "//79");
}

TEST_CASE("numbers are little-endian IEEE 754") {
  std::string text;
  append_doubles(text, std::array{1.0});  // 00 00 00 00 00 00 f0 3f
  CHECK(text == "AAAAAAAA8D8=");
  text.clear();
  append_floats(text, std::array{1.0, -2.0, 0.1});  // 00 00 80 3f, 00 00 00 c0, cd cc cc 3d
  CHECK(text == "AACAPwAAAMDNzMw9");
  text.clear();
  append_floats(text, std::array{std::numeric_limits<double>::infinity()});  // 00 00 80 7f
  CHECK(text == "AACAfw==");
}

}  // namespace
}  // namespace momentree::io
