#include <momentree/io/result_directory.hpp>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 9> our_files = {"bodies.csv",   "joints.csv", "energy.csv",  "events.jsonl", "final.json",
                                                       "summary.json", "model.json", "report.html", "result.h5"};

bool is_ours(const fs::path& file) { return std::ranges::count(our_files, file.filename().string()) > 0; }

// A result, or a folder with nothing in it. A run that was killed at its start may have left nothing but a summary.
bool replaceable(const fs::path& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) && (fs::is_empty(folder, error) || fs::is_regular_file(folder / "summary.json", error));
}

void require_replaceable(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(path, error)) || replaceable(path)) return;
  if (fs::is_directory(path, error))
    fail({"this folder has files in it, but no result of momentree: it is not replaced", path.string(),
          "name another folder with --out"});
  fail({"there is a file of that name already", path.string(), "name a folder with --out"});
}

void require_ok(const std::error_code& error, const char* what, const fs::path& path) {
  if (error) fail({std::string(what) + ": " + error.message(), path.string(), ""});
}

}  // namespace

ResultDirectory::ResultDirectory(const std::string& destination) {
  if (destination.empty()) fail({"the result folder's name is empty", "--out", "name a folder"});
  destination_ = fs::path(destination).lexically_normal();
  if (!destination_.has_filename() || destination_ == "." || destination_ == "..")  // "results/", ".", "/"
    destination_ = fs::absolute(destination_).lexically_normal();
  if (!destination_.has_filename()) destination_ = destination_.parent_path();
  if (!destination_.has_filename()) fail({"a run does not replace this folder", destination, "name another folder with --out"});
  working_ = destination_;
  working_ += ".partial";

  require_replaceable(destination_);
  require_replaceable(working_);
  std::error_code error;
  if (fs::exists(fs::symlink_status(working_, error))) {
    fs::remove_all(working_, error);
    require_ok(error, "cannot remove what an earlier run left", working_);
  }
  fs::create_directories(working_, error);
  require_ok(error, "cannot make the result folder", working_);
  if (access(working_.c_str(), W_OK | X_OK) != 0) fail({"cannot write into the result folder", working_.string(), ""});
}

void ResultDirectory::publish() {
  std::error_code error;
  fs::path former;
  if (fs::exists(fs::symlink_status(destination_, error))) {
    require_replaceable(destination_);
    for (const auto& entry : fs::directory_iterator(destination_))
      if (!is_ours(entry.path())) {
        fs::rename(entry.path(), working_ / entry.path().filename(), error);
        require_ok(error, "cannot keep this file of the earlier result", entry.path());
      }
    former = destination_;
    former += ".former";
    fs::remove_all(former, error);
    fs::rename(destination_, former, error);
    require_ok(error, "cannot replace the earlier result", destination_);
  }
  fs::rename(working_, destination_, error);
  require_ok(error, "cannot move the result to its place", destination_);
  if (!former.empty()) fs::remove_all(former, error);
}

}  // namespace momentree::io
