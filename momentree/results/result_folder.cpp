#include <momentree/results/result_folder.hpp>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

bool is_helper(const std::string& name) {
  return name == ResultMarker::file_name || name == helper::fresh || name == helper::reserve;
}

void remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT)
    fail_with_reason("cannot remove this file of an earlier run", path.string(), {errno, std::generic_category()});
}

}  // namespace

bool is_empty_folder(const fs::path& folder) { return names_in(folder).empty(); }

std::vector<std::string> others_in(const fs::path& folder, const ResultMarker& marker) {
  std::vector<std::string> names = names_in(folder);
  std::erase_if(names, [&](const std::string& name) { return is_helper(name) || marker.owns(folder, name); });
  return names;
}

void remove_own(const fs::path& folder, const ResultMarker& marker) {
  std::vector<std::string> own = names_in(folder);
  std::erase_if(own, [&](const std::string& name) {
    return name == ResultMarker::file_name || !(is_helper(name) || marker.owns(folder, name));
  });
  std::ranges::stable_partition(own, [](const std::string& name) { return name == "summary.json"; });
  for (const std::string& name : own) remove_file(folder / name);
}

void remove_if_empty(const fs::path& folder) {
  const std::vector<std::string> names = names_in(folder);
  if (names.size() > 1 || (names.size() == 1 && names[0] != ResultMarker::file_name)) return;
  remove_file(folder / ResultMarker::file_name);
  if (::rmdir(folder.c_str()) != 0 && errno != ENOENT && errno != ENOTEMPTY && errno != EEXIST)
    fail_with_reason("cannot remove this folder of an earlier run", folder.string(), {errno, std::generic_category()});
}

std::vector<std::string> retire(const fs::path& folder, const ResultMarker& marker, const fs::path& destination) {
  std::vector<std::string> warnings;
  const auto warn = [&warnings](const std::string& where, const char* what) {
    try {
      warnings.push_back(where + ": warning: " + what);
    } catch (const std::bad_alloc&) {  // nothing is lost: the next run finds the files that stay here
    }
  };
  const auto attempt = [&](const auto& action) {
    try {
      action();
    } catch (const Error& error) {
      warn(error.where, error.problem.c_str());
    } catch (const std::bad_alloc&) {
      warn(folder.native(), "out of memory: the earlier result is still here");
    }
  };
  attempt([&] {
    if (marker.owns(folder, "summary.json")) remove_file(folder / "summary.json");
  });
  attempt([&] {
    for (const std::string& name : others_in(folder, marker))
      attempt([&] {
        if (const std::error_code error = move_to_new(folder / name, destination / name))
          fail_with_reason("cannot move this to the new result", (folder / name).string(), error);
      });
  });
  attempt([&] { remove_own(folder, marker); });
  attempt([&] { remove_if_empty(folder); });
  return warnings;
}

}  // namespace momentree::io
