#include <momentree/text/json_writer.hpp>

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>

#include <momentree/text/json.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {
namespace {

TEST_CASE("numbers read back to the same bits") {
  std::mt19937_64 random(1);
  std::vector<double> numbers = {
      0.0, -0.0, 0.1, 1.0 / 3, 1e-300, 5e-324, 1e300, std::numeric_limits<double>::max(), 1e17, 123456789012345678.0};
  while (numbers.size() < 20000) {
    const double x = std::bit_cast<double>(static_cast<std::uint64_t>(random()));
    if (std::isfinite(x)) numbers.push_back(x);
  }
  std::string text;
  JsonWriter(text).value(std::span<const double>(numbers));
  std::vector<double> back;
  const Value document = parse_json(text, "numbers.json");
  for (const Value& value : *document.array()) back.push_back(value.number().value());
  REQUIRE(back.size() == numbers.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    CHECK(std::bit_cast<std::uint64_t>(back[i]) == std::bit_cast<std::uint64_t>(numbers[i]));
    const double direct = std::strtod(number_text(numbers[i]).c_str(), nullptr);
    CHECK(std::bit_cast<std::uint64_t>(direct) == std::bit_cast<std::uint64_t>(numbers[i]));
  }
}

TEST_CASE("numbers are as short as they can be") {
  CHECK(number_text(0.1) == "0.1");
  CHECK(number_text(1e22) == "1e+22");
  CHECK(number_text(-0.0) == "-0.0");
  CHECK(number_text(3) == "3");
}

TEST_CASE("objects and arrays, on lines and on one line") {
  const auto write = [](int depth) {
    std::string text;
    JsonWriter json(text, depth);
    json.begin_object().member("a", 1).key("b").begin_array().value(true).null().begin_object().end_object().end_array();
    json.member("c", Vec3{1, 2, 0.5}).key("d").begin_array().end_array().end_object();
    return text;
  };
  CHECK(write(0) == R"({"a": 1, "b": [true, null, {}], "c": [1, 2, 0.5], "d": []})");
  CHECK(write(1) == "{\n  \"a\": 1,\n  \"b\": [true, null, {}],\n  \"c\": [1, 2, 0.5],\n  \"d\": []\n}");
  CHECK(write(2) == "{\n  \"a\": 1,\n  \"b\": [\n    true,\n    null,\n    {}\n  ],\n  \"c\": [1, 2, 0.5],\n  \"d\": []\n}");
}

TEST_CASE("words are escaped") {
  std::string text;
  JsonWriter(text).value("a\"b\\c\n\x01/ä");
  CHECK(text == "\"a\\\"b\\\\c\\u000a\\u0001/ä\"");
  CHECK(*parse_json(text, "words.json").string() == "a\"b\\c\n\x01/ä");
}

TEST_CASE("whatever the bytes, the text is UTF-8 and contains no terminal commands") {
  std::string text;
  JsonWriter(text).value("\x7f\xC2\x9B\xE2\x80\xAE\xF3\xA0\x81\x81|\xFF\xE2\x80|");
  CHECK(text == "\"\\u007f\\u009b\\u202e\\udb40\\udc41|\\ufffd\\ufffd\\ufffd|\"");
  CHECK(*parse_json(text, "words.json").string() ==
        "\x7f\xC2\x9B\xE2\x80\xAE\xF3\xA0\x81\x81|\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD|");
}

TEST_CASE("non-finite numbers are null") {
  std::string text;
  const double numbers[] = {std::nan(""), 1, -INFINITY};
  JsonWriter(text).value(std::span<const double>(numbers));
  CHECK(text == "[null, 1, null]");
}

TEST_CASE("a quaternion is written with w >= 0") {
  std::string text;
  JsonWriter(text).value(Quat{-0.5, 0.5, -0.5, 0.5});
  CHECK(text == "[0.5, -0.5, 0.5, -0.5]");
}

}  // namespace
}  // namespace momentree::io
