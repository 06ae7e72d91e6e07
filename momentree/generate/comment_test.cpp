// No text from a file becomes code: texts in comments, whatever they contain, and names.
#include <momentree/generate/comment.hpp>

#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <momentree/generate/source.hpp>
#include <momentree/joint/kinds.hpp>

namespace momentree {

namespace {

const std::string code = "int evil = 1;";

/// Texts that would end or continue a comment, for some compiler with some options.
std::vector<std::string> hostile() {
  std::vector<std::string> all{"an arm"};
  for (const char* end : {"\r",
                          "\n",
                          "\r\n",
                          "\n\r",
                          "\v",
                          "\f",
                          "\\\n",
                          "\\ \n",
                          "\\\r",
                          "?\?/\n",
                          "?\?/\r\n",
                          "*/",
                          "*/ /*",
                          "//",
                          "\xc2\x85",
                          "\xe2\x80\xa8",
                          "\xe2\x80\xa9",
                          "\xe2\x80\xae",
                          "\xc2\x9b",
                          "\x1b[2K",
                          "\x1a",
                          "\x7f",
                          "\\u000a",
                          "\\u{a}",
                          "\\x0a",
                          "\xff",
                          "\xc0\x8a",
                          "\xed\xa0\x80",
                          "\xf4\x90\x80\x80",
                          "\xe2\x80",
                          "\t"})
    for (const char* tail : {"", " //", " /*", "\\", "?\?/"}) all.push_back(std::string("arm") + end + code + tail);
  all.push_back(std::string("arm\0", 4) + code);
  all.push_back("arm\n#include \"evil.h\"\n#define double int\n");
  all.push_back("arm\\");
  return all;
}

Model pendulum() {
  Model model;
  model.add({.name = "rod", .mass = 1, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}});
  return model;
}

/// The compiler's output after removing comments, without the text of the standard library.
std::string without_comments(const std::string& compiler, const std::string& flags, std::string source) {
  for (const char* include : {"#include <bit>\n", "#include <cmath>\n", "#include <cstdint>\n"}) {
    const std::size_t place = source.find(include);
    REQUIRE(place != std::string::npos);
    source.erase(place, std::string(include).size());
  }
  std::string folder = std::filesystem::temp_directory_path().string() + "/momentree-test-XXXXXX";
  REQUIRE(mkdtemp(folder.data()) != nullptr);
  std::ofstream(folder + "/in.cpp", std::ios::binary) << source;
  const int status = std::system(
      ("'" + compiler + "' " + flags + " -w -E -P '" + folder + "/in.cpp' -o '" + folder + "/out' 2>/dev/null").c_str());
  std::ifstream out(folder + "/out", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(out), {}};
  std::filesystem::remove_all(folder);
  CHECK(status == 0);
  return text;
}

}  // namespace

TEST_CASE("printable ASCII stays, everything else is a number in brackets") {
  CHECK(comment_text("An arm of 7 pins: 50% (v_1) 'a' \"b\" #x ?") == "An arm of 7 pins: 50% (v_1) 'a' \"b\" #x ?");
  CHECK(comment_text("\xc3\x9c"
                     "berschlag") == "<U+00DC>berschlag");
  CHECK(comment_text("\xf0\x9f\xa4\x96") == "<U+1F916>");
  CHECK(comment_text("a\rb\nc\td\x1b") == "a<U+000D>b<U+000A>c<U+0009>d<U+001B>");
  CHECK(comment_text("\xff\xe2\x82 \xc0\xaf") == "<0xFF><0xE2><0x82> <0xC0><0xAF>");
  CHECK(comment_text("a\\") == "a<U+005C>");
  CHECK(comment_text("?\?/ ?\??") == "?<U+003F>/ ?<U+003F>?");
  CHECK(comment_text("*/ /* **/") == "*<U+002F> /<U+002A> **<U+002F>");
  CHECK(comment_text(comment_text("\xc3\x9c\\\r*/")) == comment_text("\xc3\x9c\\\r*/"));
  CHECK(comment("") == "");
  CHECK(comment("a\n\nb") == "// a\n//\n// b\n");
}

TEST_CASE("whatever a comment contains, each of its lines is one comment") {
  for (const std::string& text : hostile()) {
    CAPTURE(text);
    const std::string found = comment(text);
    CHECK(found.ends_with('\n'));
    for (std::size_t begin = 0; begin < found.size();) {
      const std::size_t end = found.find('\n', begin);
      CHECK(found.compare(begin, 2, "//") == 0);
      for (std::size_t i = begin; i < end; ++i) CHECK((found[i] >= ' ' && found[i] <= '~' && found[i] != '\\'));
      begin = end + 1;
    }
  }
}

TEST_CASE("compilers produce the same code, whatever the comment contains") {
  const KernelExpressions kernel = kernel_expressions(Tree(pendulum()));
  const std::string plain = kernel_source(kernel);
  for (const char c : plain) REQUIRE(((c >= ' ' && c <= '~') || c == '\n'));
  std::string all;
  for (const std::string& text : hostile()) all += text + '\n';
  int compilers = 0;
  for (const char* name : {MOMENTREE_COMPILER, "g++", "clang++", "clang++-14"}) {
    if (std::system((std::string("command -v '") + name + "' > /dev/null").c_str()) != 0) continue;
    ++compilers;
    CAPTURE(name);
    for (const char* flags : {"-std=c++20", "-std=gnu++14 -trigraphs"}) {
      CAPTURE(flags);
      const std::string expected = without_comments(name, flags, plain);
      CHECK(expected.find("kernel_rates") != std::string::npos);
      CHECK(without_comments(name, flags, "int evil;\n" + plain) != expected);  // a difference would be detected
      CHECK(without_comments(name, flags, kernel_source(kernel, {"kernel", all})) == expected);
      CHECK(without_comments(name, flags, kernel_source(kernel, {"kernel", "arm\\"})) == expected);
    }
  }
  CHECK(compilers > 0);
}

TEST_CASE("names are identifiers") {
  for (const std::string& text : hostile()) {
    const std::string name = identifier(text);
    CHECK(identifier(name) == name);
    CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string::npos);
  }
  CHECK(identifier("\xc3\x9c") == "k__");
  CHECK(identifier("_x") == "k_x");
}

}  // namespace momentree
