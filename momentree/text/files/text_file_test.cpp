#include <momentree/text/files/text_file.hpp>

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <csignal>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/line_reader.hpp>

namespace momentree::io {
namespace {

/// Limits the size of files written by this process, to simulate a full disk.
class LimitedFileSize {
 public:
  explicit LimitedFileSize(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~LimitedFileSize() { lift(); }
  LimitedFileSize(const LimitedFileSize&) = delete;
  LimitedFileSize& operator=(const LimitedFileSize&) = delete;
  void lift() const { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

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

namespace fs = std::filesystem;

std::size_t count_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_CASE("a full disk is noticed") {
  if (!fs::exists("/dev/full")) return;
  const std::string message = test::error_of([] { write_text_file("/dev/full", "lost"); });
  CHECK(message.find("/dev/full") != std::string::npos);
  CHECK(message.find("free some space") != std::string::npos);
  CHECK(fs::is_character_file("/dev/full"));  // it was not replaced
}

TEST_CASE("on a full disk the file ends with the last whole line, and the rest can be written later") {
  const test::TemporaryFolder folder;
  TextFile file(folder / "a.txt");
  const LimitedFileSize limit(40);
  file.text() = "0123456789\n";
  file.flush();
  for (int k = 0; k < 3; ++k) file.text() += "0123456789abcd\n";
  CHECK(test::error_of([&] { file.flush(); }).find("a.txt: error: cannot write this file: ") != std::string::npos);
  CHECK(read_text_file(folder / "a.txt") == "0123456789\n0123456789abcd\n");
  limit.lift();
  file.close();
  CHECK(read_text_file(folder / "a.txt") == "0123456789\n0123456789abcd\n0123456789abcd\n0123456789abcd\n");
}

TEST_CASE("a file is written whole or left as it was, and no other file remains") {
  const test::TemporaryFolder folder;
  write_text_file(folder / "a.txt", "first");
  write_text_file(folder / "a.txt", "second");
  CHECK(read_text_file(folder / "a.txt") == "second");
  {
    const LimitedFileSize limit(3);
    CHECK(test::error_of([&] { write_text_file(folder / "a.txt", "third"); }).find("a.txt: error: cannot write") !=
          std::string::npos);
  }
  CHECK(read_text_file(folder / "a.txt") == "second");
  CHECK(count_in(folder / "") == 1);
}

TEST_CASE("permissions and links stay, folders are refused") {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "real");
  write_text_file(folder / "real/a.txt", "first");
  fs::permissions(folder / "real/a.txt", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real/a.txt", folder / "link");
  write_text_file(folder / "link", "second");
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(read_text_file(folder / "real/a.txt") == "second");
  CHECK(fs::status(folder / "real/a.txt").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
  fs::create_symlink("real/new.txt", folder / "ahead");
  write_text_file(folder / "ahead", "third");
  CHECK(read_text_file(folder / "real/new.txt") == "third");
  fs::create_symlink("ring", folder / "ring");
  CHECK(test::error_of([&] { write_text_file(folder / "ring", ""); }).find("cannot follow this link") != std::string::npos);
  CHECK(test::error_of([&] { write_text_file(folder / "real", ""); }).find("this is a folder") != std::string::npos);
  CHECK(count_in(folder / "real") == 2);
}

TEST_CASE("lines come one by one, the last one with or without its end, and large files through a buffer") {
  const test::TemporaryFolder folder;
  std::string all, line;
  for (int i = 0; i < 50000; ++i) all += std::to_string(i) + (i % 2 ? "\r\n" : "\n");
  write_text_file(folder / "a.csv", all + "\ncut");
  LineReader in(folder / "a.csv");
  for (int i = 0; i < 50000; ++i) {
    REQUIRE(in.next(line));
    REQUIRE(line == std::to_string(i));
    REQUIRE(in.is_whole());
  }
  CHECK((in.next(line) && line.empty() && in.is_whole() && in.number() == 50001));
  CHECK((in.next(line) && line == "cut" && !in.is_whole()));
  CHECK_FALSE(in.next(line));
}

TEST_CASE("files that cannot be read are errors with their names") {
  const test::TemporaryFolder folder;
  CHECK(test::error_of([&] { TextFile file(folder / "no/such/folder"); }).find("no/such/folder: error: cannot make") !=
        std::string::npos);
  CHECK(test::error_of([&] { write_text_file(folder / "no/such/folder", ""); }).find("no/such/folder: error: cannot write") !=
        std::string::npos);
  write_text_file(folder / "a.txt", "mine");
  CHECK(test::error_of([&] { TextFile file(folder / "a.txt"); }).find("exists") != std::string::npos);
  CHECK(test::error_of([&] { read_text_file(folder / "none"); }).find("there is no such file") != std::string::npos);
  CHECK(test::error_of([] { read_text_file("/"); }).find("this is a folder") != std::string::npos);
  CHECK(test::error_of([] { read_text_file("/dev/zero"); }).find("this is not a regular file") != std::string::npos);
}

}  // namespace
}  // namespace momentree::io
