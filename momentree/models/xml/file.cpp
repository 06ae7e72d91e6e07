#include <momentree/models/xml/file.hpp>

#include <utility>

namespace momentree::io {

namespace {
constexpr std::size_t shown_lines = 5, most_different = 200;
}

XmlFile::XmlFile(std::string path, std::string text, bool quotes)
    : path_(std::move(path)), text_(std::move(text)), out_(path_, quotes ? std::string_view(text_) : std::string_view()) {
  SyntaxError error;
  document_ = XmlDocument::parse(text_, error, quotes);
  if (!document_) out_.error(error.place, error.what, error.hint);
}

void XmlFile::once(Severity severity, const std::string& what, const std::string& hint, const XmlLocation& at) {
  const auto key = std::tuple(severity, what, hint);
  auto found = repeated_.find(key);
  if (found == repeated_.end()) {
    if (repeated_.size() >= most_different) return;
    found = repeated_.emplace(key, Repeated{}).first;
  }
  Repeated& same = found->second;
  if (same.first.size() < shown_lines) same.first.push_back(at);
  ++same.count;
}

std::vector<Diagnostic> XmlFile::take() {
  for (const auto& [key, same] : std::exchange(repeated_, {})) {
    const auto& [severity, what, hint] = key;
    std::string text = what;
    if (same.count > 1) {
      text += " (lines ";
      for (std::size_t i = 0; i < same.first.size(); ++i)
        text += (i == 0 ? "" : i + 1 == same.count ? " and " : ", ") + std::to_string(same.first[i].place().line);
      if (same.count > same.first.size()) text += " and " + std::to_string(same.count - same.first.size()) + " more";
      text += ")";
    }
    const Place place = same.first.front().place();
    if (severity == Severity::warning)
      out_.warning(place, std::move(text), hint);
    else
      out_.note(place, std::move(text), hint);
  }
  return out_.take();
}

}  // namespace momentree::io
