#include <momentree/results/result_directory.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/results/result_folder.hpp>

namespace momentree::io {

namespace fs = std::filesystem;

namespace {

Descriptor make_new(const fs::path& path) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!file) fail_with_reason("cannot make this file", path.string(), last_error());
  return file;
}

void require_real_folder(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (error) fail_with_reason("cannot access this folder", path.string(), error);
  if (fs::is_symlink(status))
    throw_error(
        {"this is a symbolic link: a run does not replace it", path.string(), "name the folder that it points to with --out"});
  if (!fs::is_directory(status)) throw_error({"there is a file of that name already", path.string(), "name a folder with --out"});
  if (::access(path.c_str(), R_OK | W_OK | X_OK) != 0)
    fail_with_reason("cannot write into this folder", path.string(), last_error());
  struct stat own {
  }, above{};
  if (::stat(path.c_str(), &own) == 0 && ::stat((path / "..").c_str(), &above) == 0 && own.st_dev != above.st_dev)
    throw_error({"this is the root of a disk, which cannot be renamed", path.string(),
                 "name a folder in it: --out " + (path / "run").string()});
}

[[noreturn]] void refuse_foreign(const fs::path& folder) {
  throw_error({"this folder has files in it, but no result of momentree: it will not be replaced", folder.string(),
               "name another folder with --out"});
}

// A new result gets the permissions of the one that it replaces.
void take_mode(const fs::path& folder, const fs::path& from) {
  struct stat status {};
  if (::stat(from.c_str(), &status) != 0 || ::chmod(folder.c_str(), status.st_mode & 0777) != 0)
    fail_with_reason("cannot set the permissions of this folder", folder.string(), last_error());
}

}  // namespace

ResultDirectory::ResultDirectory(const std::string& destination, std::vector<std::string> files, bool lasting, Earlier earlier)
    : files_(std::move(files)), lasting_(lasting), earlier_(earlier) {
  name_folders(destination);
  try {
    begin();
  } catch (...) {
    discard();
    throw;
  }
}

ResultDirectory::~ResultDirectory() {
  if (!kept_) discard();
}

void ResultDirectory::name_folders(const std::string& destination) {
  if (destination.empty()) throw_error({"the result folder's name is empty", "--out", "name a folder"});
  destination_ = fs::path(destination).lexically_normal();
  if (!destination_.has_filename() || destination_ == "." || destination_ == "..")  // "results/", ".", "/"
    destination_ = fs::absolute(destination_).lexically_normal();
  if (!destination_.has_filename()) destination_ = destination_.parent_path();
  if (!destination_.has_filename())
    throw_error({"a run does not replace this folder", destination, "name another folder with --out"});
  if (destination_.extension() == ".partial")
    throw_error({"names that end in .partial are reserved for results that are being written", destination,
                 "give another name with --out"});
  working_ = destination_;
  working_ += ".partial";
}

void ResultDirectory::begin() {
  if (is_there(destination_)) require_real_folder(destination_);
  lock_working();
  bring_back_former();
  check_destination();
  check_names();
  if (earlier_ == Earlier::kept) return;
  if (has(journal_file))
    throw_error({"this folder has the unfinished results of a sweep", working_.string(),
                 "continue it with momentree sweep, name another folder with --out, or delete this one"});
  clear();
}

void ResultDirectory::remove_all() noexcept {
  cleared_ = true;
  topmost_made_.clear();
  discard();
  kept_ = true;
}

bool ResultDirectory::has(const char* name) const { return marker_->owns(working_, name); }

void ResultDirectory::clear() {
  cleared_ = true;
  remove_former();
  remove_own(working_, *marker_);
  marker_->clear();
}

// Of a run that was killed while it removed this.
void ResultDirectory::remove_former() {
  const fs::path former = destination_ / helper::former;
  if (!is_there(former)) return;
  if (const std::optional<ResultMarker> marker = ResultMarker::lock(former))
    retire(former, *marker, destination_);
  else
    remove_if_empty(former);
}

std::unique_ptr<ResultDirectory> ResultDirectory::reopen(const std::string& destination, std::vector<std::string> files,
                                                         const char* needed) {
  std::unique_ptr<ResultDirectory> self(new ResultDirectory(std::move(files), true));
  self->kept_ = true;
  self->name_folders(destination);
  if (!is_there(self->working_ / needed)) return nullptr;
  require_real_folder(self->working_);
  self->marker_ = ResultMarker::lock(self->working_);
  if (!self->marker_ || !self->marker_->owns(self->working_, needed)) return nullptr;
  if (is_there(self->destination_)) require_real_folder(self->destination_);
  self->bring_back_former();
  self->check_destination();
  self->check_names();
  return self;
}

void ResultDirectory::take_up() {
  remove_former();
  for (const char* const name : {"summary.json", "final.json", "report.html"}) remove(name);
  for (const char* const name : {helper::fresh, helper::reserve}) ::unlink((working_ / name).c_str());
}

void ResultDirectory::to_disk() {
  if (!lasting_) return;
  marker_->to_disk();
  if (const std::error_code error = sync_folder(working_)) fail_with_reason("cannot finish writing", working_.string(), error);
}

void ResultDirectory::remove_published(const std::vector<const char*>& names, std::vector<std::string>& warnings) noexcept {
  for (const char* const name : names) try {
      const fs::path path = destination_ / name;
      if (::unlink(path.c_str()) != 0 && errno != ENOENT)
        warnings.push_back(path.native() + ": warning: this file is still here: " + last_error().message());
    } catch (const std::exception&) {  // no memory: the next run removes it
    }
}

void ResultDirectory::lock_working() {
  std::error_code error;
  for (fs::path folder = working_.parent_path(); !folder.empty() && !is_there(folder); folder = folder.parent_path())
    topmost_made_ = folder;
  if (!topmost_made_.empty()) fs::create_directories(working_.parent_path(), error);
  if (error) fail_with_reason("cannot make the result folder", working_.string(), error);
  for (int tries = 0; !marker_ && tries < 100; ++tries) {  // another run may remove or move it meanwhile
    made_ = ::mkdir(working_.c_str(), 0777) == 0;
    if (!made_ && errno != EEXIST) fail_with_reason("cannot make the result folder", working_.string(), last_error());
    if (!made_) require_real_folder(working_);
    marker_ = ResultMarker::make(working_);
    if (!marker_ && is_there(working_)) refuse_foreign(working_);
  }
  if (!marker_) throw_error({"cannot make the result folder: other programs keep removing it", working_.string(), ""});
}

// Restores the former result of a run that was killed between the two renames that replace an exchange.
void ResultDirectory::bring_back_former() {
  const fs::path former = working_ / helper::former;
  if (is_there(destination_) || !is_there(former)) return;
  if (const std::error_code error = move_to_new(former, destination_))
    fail_with_reason("cannot bring back the earlier result", former.string(), error);
}

void ResultDirectory::check_destination() {
  if (!is_there(destination_)) return;
  require_real_folder(destination_);
  destination_marker_ = ResultMarker::lock(destination_);
  if (!destination_marker_ && !is_empty_folder(destination_)) refuse_foreign(destination_);
}

void ResultDirectory::check_names() const {
  const auto check = [](const fs::path& folder, const ResultMarker& marker, const std::string& name) {
    if (is_there(folder / name) && !marker.owns(folder, name))
      throw_error({"this file was not written by momentree: it will not be replaced", (folder / name).string(),
                   "move it, or name another folder with --out"});
  };
  for (const std::string& name : files_) {
    check(working_, *marker_, name);
    if (destination_marker_) check(destination_, *destination_marker_, name);
  }
  if (destination_marker_)  // user files of the same name in both folders would collide
    for (const std::string& name : others_in(working_, *marker_)) check(destination_, *destination_marker_, name);
}

std::string ResultDirectory::file(const char* name) {
  const fs::path path = working_ / name;
  if (is_there(path) && !marker_->owns(working_, name))
    throw_error({"this file was not written by momentree: it will not be replaced", path.string(), ""});
  marker_->add({name});
  return path.string();
}

void ResultDirectory::reserve(std::size_t size) {
  const std::string path = (working_ / helper::reserve).string();
  reserve_ = make_new(path);
  std::size_t written = 0;
  if (const std::error_code error = write_all(reserve_, std::string(size, '\n'), written))
    fail_with_reason("cannot write this file", path, error);
}

void ResultDirectory::write(const char* name, std::string_view text, bool from_reserve) {
  const std::string path = file(name);
  from_reserve = from_reserve && reserve_;
  const fs::path fresh = working_ / (from_reserve ? helper::reserve : helper::fresh);
  Descriptor out = from_reserve ? std::exchange(reserve_, Descriptor()) : make_new(fresh);
  std::size_t written = 0;
  std::error_code error;
  if (from_reserve && ::lseek(out.number(), 0, SEEK_SET) != 0) error = last_error();
  if (!error) error = write_all(out, text, written);
  if (!error && from_reserve && ::ftruncate(out.number(), static_cast<off_t>(text.size())) != 0) error = last_error();
  if (!error && lasting_) error = sync(out);
  if (const std::error_code at_end = out.close(); !error) error = at_end;
  if (!error && ::rename(fresh.c_str(), path.c_str()) != 0) error = last_error();
  if (!error) return;
  ::unlink(fresh.c_str());
  fail_with_reason("cannot write this file", path, error);
}

void ResultDirectory::remove(const char* name) noexcept {
  try {
    if (marker_->names().contains(name)) ::unlink((working_ / name).c_str());
  } catch (const std::exception&) {  // no memory for its path
  }
}

void ResultDirectory::discard() noexcept {
  try {
    if (marker_ && (made_ || cleared_)) {
      remove_own(working_, *marker_);
      remove_if_empty(working_);
    } else if (marker_ && marker_->names().empty() && others_in(working_, *marker_).empty()) {
      ::unlink((working_ / ResultMarker::file_name).c_str());  // the folder was empty
    } else if (made_) {
      ::rmdir(working_.c_str());
    }
    if (topmost_made_.empty()) return;
    for (fs::path folder = working_.parent_path();; folder = folder.parent_path())
      if ((::rmdir(folder.c_str()) != 0 && errno != ENOENT) || folder == topmost_made_) break;
  } catch (const Error&) {  // the remaining files have a marker: the next run removes them
  } catch (const std::exception&) {
  }
}

std::vector<std::string> ResultDirectory::publish(const std::vector<const char*>& temporary) {
  std::vector<std::string> warnings;
  const fs::path above = destination_.parent_path();  // once the result is in its destination nothing may throw
  to_disk();
  for (int tries = 0;; ++tries) {  // the destination may change meanwhile
    if (tries == 100) throw_error({"cannot move the result to its destination", destination_.string(), ""});
    std::error_code error = move_to_new(working_, destination_);
    if (error && error != std::errc::file_exists && error != std::errc::directory_not_empty)
      fail_with_reason("cannot move the result to its destination", destination_.string(), error);
    if (!error) break;
    require_real_folder(destination_);
    if (destination_marker_ && !destination_marker_->is_in(destination_)) destination_marker_.reset();
    if (!destination_marker_) destination_marker_ = ResultMarker::lock(destination_);
    if (destination_marker_) {
      replace_destination(temporary, warnings);
      return warnings;
    }
    take_mode(working_, destination_);
    if (::rename(working_.c_str(), destination_.c_str()) == 0) break;  // it was empty
    if (is_there(destination_) && !is_empty_folder(destination_)) refuse_foreign(destination_);
  }
  kept_ = true;
  if (lasting_) sync_folder(above);
  remove_published(temporary, warnings);
  return warnings;
}

// At every instant one of the two results is at the destination. The exception is a file system without exchange: there is then
// an instant at which the earlier result is in the working folder, and the next run restores it.
void ResultDirectory::replace_destination(const std::vector<const char*>& temporary, std::vector<std::string>& warnings) {
  const fs::path above = destination_.parent_path(), within = working_ / helper::former, after = destination_ / helper::former;
  check_names();
  take_mode(working_, destination_);
  const auto require = [this](std::error_code error) {
    if (error) fail_with_reason("cannot move the result to its destination", destination_.string(), error);
  };
  const auto require_same = [this](const fs::path& folder, const auto& undo) {
    if (destination_marker_->is_in(folder)) return;
    undo();
    throw_error({"this folder was replaced by another during the run", destination_.string(), ""});
  };
  std::error_code error = exchange(working_, destination_);
  const bool exchanged = error != std::errc::operation_not_supported;
  if (exchanged) {
    require(error);
    require_same(working_, [this] { exchange(working_, destination_); });
  } else {
    const auto undo = [&] { move_to_new(within, destination_); };
    require(move_to_new(destination_, within));
    require_same(within, undo);
    error = move_to_new(working_, destination_);
    if (error) undo();
    require(error);
  }
  kept_ = true;  // from here on the working folder's name refers to the earlier result
  if (lasting_) sync_folder(above);
  remove_published(temporary, warnings);
  std::vector<std::string> more = retire(exchanged ? working_ : after, *destination_marker_, destination_);
  warnings.swap(more);
  try {
    for (std::string& warning : more) warnings.push_back(std::move(warning));
  } catch (const std::bad_alloc&) {  // the next run finds the files that stay here
  }
}

}  // namespace momentree::io
