#include <momentree/generate/private_folder.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace momentree {

namespace {

// The path without symbolic links; empty if there is no such folder.
std::string resolved(const std::string& path) {
  char* const found = realpath(path.c_str(), nullptr);
  std::string result = found == nullptr ? "" : found;
  std::free(found);
  return result;
}

bool others_can_change(const struct stat& folder) {
  if (folder.st_uid != 0 && folder.st_uid != geteuid()) return true;
  if ((folder.st_mode & S_ISVTX) != 0) return false;
  const bool group = (folder.st_mode & S_IWGRP) != 0 && folder.st_gid != 0 && folder.st_gid != getegid();
  return group || (folder.st_mode & S_IWOTH) != 0;
}

}  // namespace

std::string open_to_others(std::string folder) {
  for (;;) {
    struct stat about {};
    if (lstat(folder.c_str(), &about) != 0 || others_can_change(about)) return folder;
    if (folder == "/") return "";
    folder.resize(folder.rfind('/'));
    if (folder.empty()) folder = "/";
  }
}

PrivateFolder::PrivateFolder() {
  const char* const given = std::getenv("TMPDIR");
  const std::string temporary = given != nullptr && *given != '\0' ? given : "/tmp";
  const std::string above = resolved(temporary);
  if (above.empty()) {
    problem_ = "there is no folder '" + temporary + "' for generated code: set TMPDIR to one";
    return;
  }
  if (const std::string open = open_to_others(above); !open.empty()) {
    problem_ = "other users can replace files in '" + open + "'; set TMPDIR to a folder that only you can write to";
    return;
  }
  std::string name = above + "/momentree-XXXXXX";
  if (mkdtemp(name.data()) != nullptr)  // mode 0700
    path_ = std::move(name);
  else
    problem_ = "no folder for generated code could be made in '" + above + "', which TMPDIR names: " + std::strerror(errno);
}

PrivateFolder::~PrivateFolder() {
  if (path_.empty()) return;
  char path[4096];  // no allocation: the folder is also removed when memory has run out
  for (const char* name : names)
    if (std::snprintf(path, sizeof path, "%s/%s", path_.c_str(), name) < static_cast<int>(sizeof path)) unlink(path);
  rmdir(path_.c_str());
}

}  // namespace momentree
