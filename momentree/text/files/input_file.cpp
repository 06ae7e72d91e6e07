#include <momentree/text/files/input_file.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <momentree/text/files/system_file.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

Unreadable refusal(int reason) {
  switch (reason) {
    case ENOENT:
    case ENOTDIR: return {"there is no such file", "", true};
    case EACCES:
    case EPERM: return {"cannot be read: permission denied", "check the permissions of the file and of the folders above it"};
    case ELOOP: return {"cannot be read: its symbolic links form a cycle", ""};
    default: return {std::string("cannot be read: ") + std::strerror(reason), ""};
  }
}

std::optional<Unreadable> refusal(const struct stat& status, const char* what) {
  if (S_ISREG(status.st_mode)) return {};
  if (S_ISDIR(status.st_mode)) return Unreadable{"is a folder, not a " + std::string(what), "name the file in it"};
  return Unreadable{"is not a regular file", ""};
}

}  // namespace

std::optional<Unreadable> why_unreadable(const std::string& path, const char* what) {
  struct stat status {};
  if (path.find('\0') != std::string::npos) return refusal(ENOENT);  // the system would read only the part before it
  if (stat(path.c_str(), &status) != 0) return refusal(errno);
  return refusal(status, what);
}

bool read_whole_file(const std::string& path, const char* what, std::uintmax_t largest, std::string& text, Unreadable& why) {
  const auto refuse = [&why](Unreadable reason) {
    why = std::move(reason);
    return false;
  };
  if (auto reason = why_unreadable(path, what)) return refuse(std::move(*reason));
  // Checked again after opening: the file may have been replaced meanwhile, for example by a pipe without a writer.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  struct stat status {};
  if (!file || fstat(file.number(), &status) != 0) return refuse(refusal(errno));
  if (auto reason = refusal(status, what)) return refuse(std::move(*reason));
  const auto size = static_cast<std::uintmax_t>(status.st_size);
  if (size > largest) return refuse({"is larger than " + std::to_string(largest >> 20) + " MiB, the limit for a " + what, ""});
  text = read_all(file, static_cast<std::size_t>(largest), path);
  if (text.size() < size) return refuse({"became shorter while it was read", "is it being written? try again"});
  return true;
}

Enclosure::Enclosure(const std::string& path) {
  const auto enclose = [this](const fs::path& file) {
    std::error_code failed;
    const fs::path folder = fs::canonical(file.has_parent_path() ? file.parent_path() : fs::path("."), failed);
    if (!failed) folders_.push_back(folder);
  };
  std::error_code failed;
  enclose(path);
  if (const fs::path real = fs::canonical(path, failed); !failed) enclose(real);
}

bool Enclosure::holds(const fs::path& path) const {
  std::error_code failed;
  const fs::path real = fs::canonical(path, failed);
  if (failed) return true;
  return std::any_of(folders_.begin(), folders_.end(), [&real](const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end();
  });
}

}  // namespace momentree::io
