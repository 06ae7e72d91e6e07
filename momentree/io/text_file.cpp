#include <momentree/io/text_file.hpp>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::io {

namespace {
[[noreturn]] void fail_with_reason(const char* what, const std::string& path) {
  const int reason = errno;
  fail({std::string(what) + ": " + std::strerror(reason), path,
        reason == ENOSPC ? "free some space on that disk, or write elsewhere" : ""});
}
}  // namespace

TextFile::TextFile(std::string path) : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wb")) {
  if (!file_) fail_with_reason("cannot write this file", path_);
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // text_ is the buffer
}

void TextFile::flush() {
  errno = 0;
  if (!text_.empty() && std::fwrite(text_.data(), 1, text_.size(), file_.get()) != text_.size())
    fail_with_reason("cannot write on", path_);
  text_.clear();
}

void TextFile::close() {
  flush();
  errno = 0;
  if (std::fclose(file_.release()) != 0) fail_with_reason("cannot finish writing", path_);
}

void write_text_file(const std::string& path, std::string_view text) {
  TextFile file(path);
  file.text() = text;
  file.close();
}

std::string read_text_file(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail({"there is no such file", path, ""});
  if (!std::filesystem::is_regular_file(status)) fail({"this is not a file", path, "give the path of a text file"});
  constexpr std::uintmax_t largest = 1u << 30;
  const auto size = std::filesystem::file_size(path, error);
  if (error) fail({"cannot read this file: " + error.message(), path, ""});
  if (size > largest) fail({"this file is larger than 1 GiB", path, ""});
  errno = 0;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) fail_with_reason("cannot read this file", path);
  std::string text(static_cast<std::size_t>(size), '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) fail_with_reason("cannot read this file", path);
  return text;
}

}  // namespace momentree::io
