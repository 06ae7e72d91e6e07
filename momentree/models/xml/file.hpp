#pragma once
// An XML file while it is read: its text, its diagnostics, and notes on what is ignored.
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <momentree/models/xml/document.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

/// An element, or one of its attributes. Its place is computed only on demand.
struct XmlLocation {
  static constexpr std::size_t no_attribute = static_cast<std::size_t>(-1);
  XmlElement element{};
  std::size_t attribute = no_attribute;
  bool of_text = false;  ///< of the element's characters
  bool of_name = false;  ///< of the attribute's name, not of its value
  Place place() const {
    if (!element) return {};
    if (attribute != no_attribute) return element.attribute_place(attribute, !of_name);
    return of_text ? element.text_place() : element.place();
  }
};

class XmlFile {
 public:
  /// Parses the text; if that fails, the error is reported and there is no root. `quotes`: messages may quote lines of the
  /// file.
  XmlFile(std::string path, std::string text, bool quotes = true);
  XmlFile(const XmlFile&) = delete;
  XmlFile& operator=(const XmlFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& text() const { return text_; }
  bool has(XmlElement element) const { return element.document() == document_.get(); }
  XmlElement root() const { return document_ ? document_->root() : XmlElement{}; }
  Diagnostics& out() { return out_; }

  void error(const XmlLocation& at, std::string what, std::string hint = {}) {
    if (out_.full()) return out_.error({}, "", "");  // only counted
    out_.error(at.place(), std::move(what), std::move(hint));
  }
  /// The limit on errors is reached: a reader stops, and the last message says so.
  bool enough() {
    if (out_.full()) out_.error({}, "", "");
    return out_.full();
  }
  void warning(const XmlLocation& at, std::string what, std::string hint = {}) {
    out_.warning(at.place(), std::move(what), std::move(hint));
  }
  std::string line_of(XmlElement element) const { return "line " + std::to_string(element.place().line); }

  /// True while the budget of name comparisons for suggestions lasts.
  bool may_suggest() { return suggestions_left_ > 0 && suggestions_left_-- > 0; }

  /// Reports similar problems once per file, with their lines: "<gazebo> is ignored (lines 3, 9 and 12)".
  void once(Severity severity, const std::string& what, const std::string& hint, const XmlLocation& at);
  /// All diagnostics, in the order of the file.
  std::vector<Diagnostic> take();

 private:
  struct Repeated {
    std::vector<XmlLocation> first;  // a few
    std::size_t count = 0;
  };
  std::string path_, text_;
  Diagnostics out_;
  std::unique_ptr<const XmlDocument> document_;
  int suggestions_left_ = 200'000;
  std::map<std::tuple<Severity, std::string, std::string>, Repeated> repeated_;
};

}  // namespace momentree::io
