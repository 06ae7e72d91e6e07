#include <momentree/text/files/line_reader.hpp>

namespace momentree::io {

LineReader::LineReader(const std::filesystem::path& file) : path_(file.string()), file_(open_regular(path_, Links::refuse)) {}

bool LineReader::refill() {
  constexpr std::size_t size = 1u << 16;
  buffer_.resize(size);
  buffer_.resize(read_some(file_, buffer_.data(), size, path_));
  at_ = 0;
  return !buffer_.empty();
}

bool LineReader::next(std::string& line) {
  line.clear();
  whole_ = false;
  while (!whole_ && (at_ < buffer_.size() || refill())) {
    const std::size_t end = buffer_.find('\n', at_);
    whole_ = end != std::string::npos;
    line.append(buffer_, at_, (whole_ ? end : buffer_.size()) - at_);
    at_ = whole_ ? end + 1 : buffer_.size();
  }
  if (line.empty() && !whole_) return false;
  if (line.ends_with('\r')) line.pop_back();
  ++number_;
  return true;
}

}  // namespace momentree::io
