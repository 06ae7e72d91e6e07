#include <momentree/io/text_file.hpp>

#include <doctest/doctest.h>

#include <momentree/io/test_support.hpp>

namespace momentree::io {
namespace {

TEST_CASE("large texts pass through the buffer") {
  const test::TemporaryFolder folder;
  TextFile file(folder / "a.txt");
  std::string all;
  for (int i = 0; i < 200000; ++i) {
    const std::string line = std::to_string(i) + '\n';
    file.text() += line;
    all += line;
    file.settle();
  }
  file.close();
  CHECK(read_text_file(folder / "a.txt") == all);
}

TEST_CASE("a full disk is noticed") {
  if (!std::filesystem::exists("/dev/full")) return;
  TextFile file("/dev/full");
  file.text() = "lost";
  const std::string message = test::error_of([&] { file.close(); });
  CHECK(message.find("/dev/full") != std::string::npos);
  CHECK(message.find("free some space") != std::string::npos);
}

TEST_CASE("files that can't be had are errors with their names") {
  const test::TemporaryFolder folder;
  CHECK(test::error_of([&] { TextFile file(folder / "no/such/folder"); }).find("no/such/folder: error: cannot write") !=
        std::string::npos);
  CHECK(test::error_of([&] { read_text_file(folder / "none"); }).find("there is no such file") != std::string::npos);
  CHECK(test::error_of([] { read_text_file("/"); }).find("this is not a file") != std::string::npos);
  CHECK(test::error_of([] { read_text_file("/dev/zero"); }).find("this is not a file") != std::string::npos);
}

}  // namespace
}  // namespace momentree::io
