#include <momentree/results/result_directory.hpp>

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> all_files = {"summary.json", "joints.csv", "report.html"};

std::string mistake(const std::string& path) {
  return test::error_of([&] { const ResultDirectory result(path, all_files); });
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// A result of two files in `path`.
void make_result(const std::string& path, const char* text) {
  ResultDirectory result(path, all_files);
  result.write("summary.json", text);
  result.write("joints.csv", text);
  result.keep();
  CHECK(result.publish().empty());
}

/// The files of a run that ended before it was published.
void make_partial(const std::string& path, const char* text) {
  ResultDirectory result(path, all_files);
  result.write("summary.json", text);
  result.write("report.html", text);
  result.keep();
}

TEST_CASE("a result is written next to its destination and moved there") {
  const test::TemporaryFolder folder;
  ResultDirectory result(folder / "a/b/");
  CHECK(result.destination() == folder / "a/b");
  CHECK(fs::is_directory(folder / "a/b.partial"));
  result.write("summary.json", "{}");
  CHECK_FALSE(fs::exists(folder / "a/b"));
  CHECK(result.publish().empty());
  CHECK(read_text_file(folder / "a/b/summary.json") == "{}");
  CHECK_FALSE(fs::exists(folder / "a/b.partial"));
}

TEST_CASE("an earlier result is replaced, and other files are kept, wherever they were") {
  const test::TemporaryFolder folder;
  make_result(folder / "r", "old");
  make_partial(folder / "r", "older");
  write_text_file(folder / "r/picture.svg", "mine");
  fs::create_directories(folder / "r/notes/more");
  write_text_file(folder / "r/notes/more/page.txt", "mine, too");
  write_text_file(folder / "r.partial/why.txt", "and this");
  write_text_file(folder / "r.former", "precious");
  fs::permissions(folder / "r", fs::perms::owner_all);
  ResultDirectory result(folder / "r", all_files);
  CHECK_FALSE(fs::exists(folder / "r.partial/summary.json"));
  CHECK_FALSE(fs::exists(folder / "r.partial/report.html"));
  CHECK(read_text_file(folder / "r/summary.json") == "old");
  result.write("summary.json", "new");
  CHECK(result.publish().empty());
  CHECK(read_text_file(folder / "r/summary.json") == "new");
  CHECK(read_text_file(folder / "r/picture.svg") == "mine");
  CHECK(read_text_file(folder / "r/notes/more/page.txt") == "mine, too");
  CHECK(read_text_file(folder / "r/why.txt") == "and this");
  CHECK(read_text_file(folder / "r.former") == "precious");
  CHECK_FALSE(fs::exists(folder / "r/joints.csv"));
  CHECK_FALSE(fs::exists(folder / "r.partial"));
  CHECK(fs::status(folder / "r").permissions() == fs::perms::owner_all);
}

TEST_CASE("a folder that is not a result is not replaced, and nothing is made next to it") {
  const test::TemporaryFolder folder;
  for (const char* name : {"thesis", "web", "empty", "marked", "busy.partial"}) fs::create_directories(folder / name);
  write_text_file(folder / "thesis/chapter.tex", "years of work");
  write_text_file(folder / "web/summary.json", "{\"name\": \"mine\"}");
  write_text_file(folder / "marked/.momentree", "my notes on momentree");
  write_text_file(folder / "busy.partial/own", "mine");
  write_text_file(folder / "file", "x");
  fs::create_directory_symlink(folder / "empty", folder / "link");
  CHECK(has(mistake(folder / "thesis"), "no result of momentree"));
  CHECK(has(mistake(folder / "web"), "no result of momentree"));
  CHECK(has(mistake(folder / "marked"), "no result of momentree"));
  CHECK(has(mistake(folder / "busy"), "busy.partial: error: this folder has files in it, but no result of momentree"));
  CHECK(has(mistake(folder / "file"), "a file of that name"));
  CHECK(has(mistake(folder / "link"), "symbolic link"));
  CHECK(has(mistake(folder / "file/below"), "cannot make the result folder"));
  CHECK(has(mistake(""), "empty"));
  CHECK(has(mistake("/"), "does not replace"));
  CHECK(mistake(folder / "empty") == "");
  CHECK(mistake(folder / "new/and/deep") == "");
  for (const char* none : {"thesis.partial", "web.partial", "marked.partial", "link.partial", "empty.partial", "new", "busy"})
    CHECK_FALSE_MESSAGE(fs::exists(folder / none), none);
  CHECK(read_text_file(folder / "web/summary.json") == "{\"name\": \"mine\"}");
  CHECK(read_text_file(folder / "busy.partial/own") == "mine");
}

TEST_CASE("a file of the user's with a name that a run writes is not replaced") {
  const test::TemporaryFolder folder;
  make_result(folder / "r", "old");
  write_text_file(folder / "r/report.html", "mine");
  CHECK(has(mistake(folder / "r"), "r/report.html: error: this file was not written by momentree"));
  fs::remove(folder / "r/report.html");
  fs::remove(folder / "r/joints.csv");
  fs::create_symlink("elsewhere", folder / "r/joints.csv");
  CHECK(has(mistake(folder / "r"), "r/joints.csv: error: this file was not written by momentree"));
  fs::remove(folder / "r/joints.csv");
  make_partial(folder / "r", "old");
  write_text_file(folder / "r.partial/joints.csv", "mine");
  CHECK(has(mistake(folder / "r"), "r.partial/joints.csv: error: this file was not written by momentree"));
  CHECK(read_text_file(folder / "r.partial/report.html") == "old");  // a refused run changes nothing
  fs::remove(folder / "r.partial/joints.csv");
  write_text_file(folder / "r.partial/notes", "one");
  write_text_file(folder / "r/notes", "other");
  CHECK(has(mistake(folder / "r"), "r/notes: error: this file was not written by momentree"));
}

TEST_CASE("one run at a time works on a folder") {
  const test::TemporaryFolder folder;
  make_result(folder / "r", "old");
  {
    ResultDirectory first(folder / "r");
    first.write("summary.json", "new");
    CHECK(has(mistake(folder / "r"), "r.partial: error: another run of momentree is writing into this folder"));
    CHECK(has(mistake(folder / "r.partial"), "names that end in .partial"));  // the first run moves it away
    CHECK(read_text_file(folder / "r.partial/summary.json") == "new");
    CHECK(first.publish().empty());
  }
  CHECK(mistake(folder / "r") == "");
  CHECK(read_text_file(folder / "r/summary.json") == "new");
}

TEST_CASE("a destination that appears during the run is not replaced") {
  const test::TemporaryFolder folder;
  {
    ResultDirectory result(folder / "r", all_files);
    result.keep();
    result.write("summary.json", "new");
    fs::create_directories(folder / "r");
    write_text_file(folder / "r/own", "mine");
    CHECK(has(test::error_of([&] { result.publish(); }), "it will not be replaced"));
  }
  CHECK(read_text_file(folder / "r/own") == "mine");
  CHECK(read_text_file(folder / "r.partial/summary.json") == "new");
  fs::remove_all(folder / "r");
  make_result(folder / "r", "old");
  ResultDirectory result(folder / "r", all_files);
  result.keep();
  write_text_file(folder / "r/report.html", "mine");
  CHECK(has(test::error_of([&] { result.publish(); }), "report.html: error: this file was not written by momentree"));
  fs::remove_all(folder / "r");
  CHECK(result.publish().empty());  // the earlier result is gone
  CHECK_FALSE(fs::exists(folder / "r/report.html"));
}

TEST_CASE("files are whole or absent, and replace no other program's files") {
  const test::TemporaryFolder folder;
  ResultDirectory result(folder / "r");
  write_text_file(folder / "r.partial/mine", "mine");
  CHECK(has(test::error_of([&] { result.file("mine"); }), "will not be replaced"));
  CHECK(has(test::error_of([&] { result.write("mine", "x"); }), "will not be replaced"));
  result.reserve(100);
  result.write("summary.json", "one");
  result.write("summary.json", "two", true);
  result.write("summary.json", "three", true);  // written without reserved space, like other files
  CHECK(read_text_file(folder / "r.partial/summary.json") == "three");
  result.remove("summary.json");
  result.remove("mine");
  CHECK_FALSE(fs::exists(folder / "r.partial/summary.json"));
  CHECK(read_text_file(folder / "r.partial/mine") == "mine");
}

TEST_CASE("a run killed between the renames that replace an exchange: the next one restores the result") {
  const test::TemporaryFolder folder;
  make_result(folder / "r", "old");
  make_partial(folder / "r", "new");
  fs::rename(folder / "r", folder / "r.partial/.momentree.former");
  { const ResultDirectory next(folder / "r", all_files); }
  CHECK(read_text_file(folder / "r/summary.json") == "old");
  CHECK_FALSE(fs::exists(folder / "r.partial"));

  make_result(folder / "other", "older");  // after the renames, before it removed the earlier one
  write_text_file(folder / "other/own", "mine");
  fs::rename(folder / "other", folder / "r/.momentree.former");
  { const ResultDirectory next(folder / "r", all_files); }
  CHECK(read_text_file(folder / "r/summary.json") == "old");
  CHECK(read_text_file(folder / "r/own") == "mine");
  CHECK_FALSE(fs::exists(folder / "r/.momentree.former"));
}

}  // namespace
}  // namespace momentree::io
