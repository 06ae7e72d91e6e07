#include <momentree/text/files/input_file.hpp>

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/file_name.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {
namespace {

namespace fs = std::filesystem;

// Acts as a user without privileges, so that file permissions apply.
class Nobody {
 public:
  Nobody() : root_(geteuid() == 0) {
    if (root_ && seteuid(65534) != 0) root_ = false;
  }
  ~Nobody() {
    if (root_ && seteuid(0) != 0) std::abort();
  }
  Nobody(const Nobody&) = delete;
  Nobody& operator=(const Nobody&) = delete;

 private:
  bool root_;
};

std::string refusal_of(const std::string& path, std::uintmax_t largest = 100) {
  std::string text;
  Unreadable why;
  return read_whole_file(path, "model", largest, text, why) ? "" : why.what;
}

TEST_CASE("only regular files up to a size limit are read") {
  const test::TemporaryFolder folder;
  write_text_file(folder / "a", "some text");
  write_text_file(folder / "empty", "");
  fs::create_symlink("a", folder / "link");
  std::string text;
  Unreadable why;
  for (const char* name : {"a", "link"}) {
    REQUIRE(read_whole_file(folder / name, "model", 9, text, why));
    CHECK(text == "some text");
  }
  REQUIRE(read_whole_file(folder / "empty", "model", 0, text, why));
  CHECK(text.empty());
  CHECK(refusal_of(folder / "a", 8) == "is larger than 0 MiB, the limit for a model");
  CHECK(refusal_of(folder / "none") == "there is no such file");
  CHECK(refusal_of(folder / "a/b") == "there is no such file");
  CHECK(refusal_of((folder / "a") + std::string("\0b", 2)) == "there is no such file");
  CHECK(refusal_of(folder / "") == "is a folder, not a model");
}

TEST_CASE("devices, pipes and sockets are refused without blocking") {
  const test::TemporaryFolder folder;
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  fs::create_symlink("pipe", folder / "link");
  for (const std::string& path : {folder / "pipe", folder / "link", std::string("/dev/zero"), std::string("/dev/tty")})
    if (fs::exists(path)) CHECK(refusal_of(path) == "is not a regular file");
}

TEST_CASE("a file that may not be read is not one that is missing") {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "closed");
  write_text_file(folder / "closed/a", "x");
  write_text_file(folder / "b", "x");
  fs::permissions(folder / "", fs::perms::all);
  fs::permissions(folder / "closed", fs::perms::none);
  fs::permissions(folder / "b", fs::perms::none);
  {
    const Nobody nobody;
    CHECK(refusal_of(folder / "closed/a") == "cannot be read: permission denied");
    CHECK(refusal_of(folder / "closed/none") == "cannot be read: permission denied");
    CHECK(refusal_of(folder / "b") == "cannot be read: permission denied");
  }
  fs::permissions(folder / "closed", fs::perms::all);
  fs::create_symlink("round", folder / "round");
  CHECK(refusal_of(folder / "round") == "cannot be read: its symbolic links form a cycle");
}

TEST_CASE("an enclosure is a folder with what is below it, symbolic links followed") {
  const test::TemporaryFolder folder;
  for (const char* name : {"models/meshes", "secret", "real/meshes", "models2"}) fs::create_directories(folder / name);
  for (const char* name : {"models/r", "models/meshes/a", "secret/s", "real/r", "real/meshes/a", "models2/x"})
    write_text_file(folder / name, "");
  fs::create_symlink("../secret/s", folder / "models/file");
  fs::create_symlink("../secret", folder / "models/folder");
  fs::create_symlink("meshes/a", folder / "models/inside");
  fs::create_symlink("models", folder / "same");
  fs::create_symlink("../real/r", folder / "models/elsewhere");

  const auto holds = [&](const char* file, const char* name) {
    return Enclosure(folder / file).holds((fs::path(folder / file).parent_path() / name).string());
  };
  for (const char* name : {"r", "meshes/a", "inside", "meshes/../r", "none", "../models/r"})
    CHECK_MESSAGE(holds("models/r", name), name);
  for (const char* name : {"file", "folder/s", "folder", "../secret/s", "folder/../real/r", "../models2/x", "elsewhere"})
    CHECK_MESSAGE(!holds("models/r", name), name);
  // Named through a link to its folder.
  CHECK(holds("same/r", "meshes/a"));
  CHECK(!holds("same/r", "file"));
  // A file that is itself a link may name files next to the link and next to its target.
  CHECK(holds("models/elsewhere", "meshes/a"));
  CHECK(Enclosure(folder / "models/elsewhere").holds(folder / "real/meshes/a"));
  CHECK(!holds("models/elsewhere", "folder/s"));
}

TEST_CASE("names that refer to a file elsewhere") {
  for (const char* name : {"a", "a/b", "./a", "a/../b", "a/./../b", "..a", "a..", "größe/é"})
    CHECK_MESSAGE(!leaves_folder(name), name);
  for (const char* name : {"/a", "..", "../a", "a/../../b", "a/../..", "a\\b", "a\nb", "a\x1b", "\xFF"})
    CHECK_MESSAGE(leaves_folder(name), name);
  CHECK(leaves_folder(std::string("a\0b", 3)));
}

}  // namespace
}  // namespace momentree::io
