#include <momentree/generate/private_folder.hpp>

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>

namespace momentree {

namespace {

namespace fs = std::filesystem;

/// A temporary folder of this test; it is TMPDIR during its lifetime.
class Place {
 public:
  Place() {
    std::string name = fs::canonical(fs::temp_directory_path()).string() + "/momentree-test-XXXXXX";
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
    if (const char* given = std::getenv("TMPDIR"); given != nullptr) before_ = given;
    become(path_);
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  ~Place() {
    before_ ? setenv("TMPDIR", before_->c_str(), 1) : unsetenv("TMPDIR");
    fs::remove_all(path_);
  }
  const fs::path& path() const { return path_; }
  static void become(const fs::path& temporary) { setenv("TMPDIR", temporary.c_str(), 1); }
  fs::path folder(const char* name, mode_t mode) const {
    fs::create_directory(path_ / name);
    REQUIRE(chmod((path_ / name).c_str(), mode) == 0);
    return path_ / name;
  }

 private:
  fs::path path_;
  std::optional<std::string> before_;
};

}  // namespace

TEST_CASE("the folder is private to this user, and is removed with its files") {
  const Place place;
  std::string path;
  {
    const PrivateFolder folder, other;
    REQUIRE(folder.made());
    CHECK(folder.problem() == "");
    path = fs::path(folder.file("kernel.cpp")).parent_path();
    CHECK(path.starts_with(place.path().string() + '/'));
    CHECK(other.file("x") != folder.file("x"));
    struct stat about {};
    REQUIRE(stat(path.c_str(), &about) == 0);
    CHECK((about.st_mode & 0777u) == 0700u);
    CHECK(about.st_uid == geteuid());
    for (const char* name : PrivateFolder::names) std::ofstream(folder.file(name)) << "x";
  }
  CHECK_FALSE(fs::exists(path));
  CHECK(fs::is_empty(place.path()));
}

TEST_CASE("paths are absolute, and no symbolic link is part of them") {
  const Place place;
  const fs::path here = fs::current_path();
  place.folder("real", 0700);
  fs::create_directory_symlink("real", place.path() / "link");
  fs::current_path(place.path());
  for (const char* temporary : {"link", "./real", "real/"}) {
    Place::become(temporary);
    const PrivateFolder folder;
    CHECK(folder.file("kernel.so").starts_with((place.path() / "real/momentree-").string()));
  }
  fs::current_path(here);
}

TEST_CASE("no folder is made where other users could replace it") {
  const Place place;
  const fs::path open = place.folder("open", 0777), sticky = place.folder("sticky", 01777);
  fs::create_directory(open / "within");
  fs::create_directory_symlink(open, place.path() / "link");
  for (const fs::path& temporary : {open, open / "within", place.path() / "link"}) {
    CAPTURE(temporary.string());
    Place::become(temporary);
    const PrivateFolder folder;
    CHECK_FALSE(folder.made());
    CHECK(folder.problem().find("'" + open.string() + "'") != std::string::npos);
    CHECK(folder.problem().find("TMPDIR") != std::string::npos);
  }
  Place::become(sticky);
  CHECK(PrivateFolder().made());
  if (geteuid() != 0) return;  // only root can give a folder away
  REQUIRE(chown(sticky.c_str(), 12345, 12345) == 0);
  CHECK_FALSE(PrivateFolder().made());
  REQUIRE(chown(sticky.c_str(), 0, 12345) == 0);
  REQUIRE(chmod(sticky.c_str(), 0770) == 0);
  CHECK_FALSE(PrivateFolder().made());
}

TEST_CASE("a TMPDIR that does not exist") {
  const Place place;
  Place::become("/nowhere/at/all");
  const PrivateFolder folder;
  CHECK_FALSE(folder.made());
  CHECK(folder.problem().find("there is no folder '/nowhere/at/all'") != std::string::npos);
}

}  // namespace momentree
