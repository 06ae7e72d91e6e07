#include <momentree/io/result_directory.hpp>

#include <doctest/doctest.h>

#include <momentree/io/test_support.hpp>
#include <momentree/io/text_file.hpp>

namespace momentree::io {
namespace {

namespace fs = std::filesystem;

TEST_CASE("a result is written beside its place and moved there") {
  const test::TemporaryFolder folder;
  ResultDirectory result(folder / "a/b/");
  CHECK(result.destination() == folder / "a/b");
  CHECK(fs::is_directory(folder / "a/b.partial"));
  write_text_file(result.file("summary.json"), "{}");
  CHECK_FALSE(fs::exists(folder / "a/b"));
  result.publish();
  CHECK(read_text_file(folder / "a/b/summary.json") == "{}");
  CHECK_FALSE(fs::exists(folder / "a/b.partial"));
}

TEST_CASE("an earlier result is replaced, what is not ours is kept") {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "r");
  fs::create_directories(folder / "r.partial");
  write_text_file(folder / "r/summary.json", "old");
  write_text_file(folder / "r/joints.csv", "old");
  write_text_file(folder / "r/picture.svg", "mine");
  write_text_file(folder / "r.partial/summary.json", "older");
  ResultDirectory result(folder / "r");
  CHECK(fs::is_empty(folder / "r.partial"));
  CHECK(read_text_file(folder / "r/summary.json") == "old");
  write_text_file(result.file("summary.json"), "new");
  result.publish();
  CHECK(read_text_file(folder / "r/summary.json") == "new");
  CHECK(read_text_file(folder / "r/picture.svg") == "mine");
  CHECK_FALSE(fs::exists(folder / "r/joints.csv"));
  CHECK_FALSE(fs::exists(folder / "r.former"));
}

TEST_CASE("what is no result is not replaced") {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "thesis");
  fs::create_directories(folder / "empty");
  write_text_file(folder / "thesis/chapter.tex", "years of work");
  write_text_file(folder / "file", "x");
  const auto mistake = [](const std::string& path) { return test::error_of([&] { ResultDirectory result(path); }); };
  CHECK(mistake(folder / "thesis").find("no result of momentree") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "thesis.partial"));
  CHECK(mistake(folder / "file").find("a file of that name") != std::string::npos);
  CHECK(mistake(folder / "file/below").find("cannot make the result folder") != std::string::npos);
  CHECK(mistake("").find("empty") != std::string::npos);
  CHECK(mistake("/").find("does not replace") != std::string::npos);
  CHECK(mistake(folder / "empty") == "");
}

}  // namespace
}  // namespace momentree::io
