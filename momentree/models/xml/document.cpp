#include <momentree/models/xml/document.hpp>

#include <expat.h>

#include <algorithm>
#include <exception>
#include <unordered_map>

#include <momentree/text/diagnostic.hpp>
#include <momentree/text/utf8.hpp>

namespace momentree::io {

std::string_view first_tag(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const std::string_view end = text.starts_with("<!--") ? "-->" : text.starts_with("<?") ? "?>" : "";
    if (end.empty()) break;
    const std::size_t at = text.find(end, end.size() + 1);
    if (at == std::string_view::npos) return {};
    text.remove_prefix(at + end.size());
  }
  if (!text.starts_with('<')) return {};
  text.remove_prefix(1);
  return text.substr(0, text.find_first_of(" \t\r\n/>"));
}

// The callbacks for expat.
class XmlDocument::Builder {
 public:
  Builder(XmlDocument& document, SyntaxError& error, bool quotes)
      : document_(document),
        content_(document.content_),
        error_(error),
        quotes_(quotes),
        parser_(XML_ParserCreate("UTF-8"), XML_ParserFree) {}

  bool build() {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &started, &ended);
    XML_SetCharacterDataHandler(parser_.get(), &characters);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &document_type);
    const std::string_view text = content_.text;
    const XML_Status status = XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
    if (failure_) std::rethrow_exception(failure_);
    if (status == XML_STATUS_OK) return true;
    if (error_.what.empty()) explain();
    return false;
  }

 private:
  struct Open {
    std::uint32_t node;
    std::uint32_t last_child = XmlDocument::none;
  };

  static Builder& self(void* user) { return *static_cast<Builder*>(user); }
  // Exceptions must not pass through expat, which is C: its memory would leak. They are thrown again when it has returned.
  template <class F>
  void guarded(const F& f) {
    if (failure_) return;
    try {
      f();
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }
  static void XMLCALL started(void* user, const char* name, const char** attributes) {
    self(user).guarded([&] { self(user).start(name, attributes); });
  }
  static void XMLCALL ended(void* user, const char*) {
    self(user).guarded([&] { self(user).end(); });
  }
  static void XMLCALL characters(void* user, const char* text, int size) {
    self(user).guarded([&] { self(user).add_text({text, static_cast<std::size_t>(size)}); });
  }
  static void XMLCALL document_type(void* user, const char*, const char*, const char*, int) {
    self(user).guarded([&] { self(user).refuse_document_type(); });
  }
  void refuse_document_type() {
    const std::size_t begin = content_.text.rfind("<!DOCTYPE", offset());
    stop_at(begin == std::string_view::npos ? offset() : begin,
            "a document type (<!DOCTYPE …>) is not supported: no entity is declared, expanded or fetched",
            "leave it out: a model needs none");
  }

  std::size_t offset() const { return static_cast<std::size_t>(std::max<XML_Index>(XML_GetCurrentByteIndex(parser_.get()), 0)); }

  void stop(std::string what, std::string hint) { stop_at(offset(), std::move(what), std::move(hint)); }
  void stop_at(std::size_t offset, std::string what, std::string hint) {
    if (!error_.what.empty()) return;
    error_ = {document_.place_at(offset), std::move(what), std::move(hint)};
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  std::uint32_t name_of(std::string_view name) {
    const auto found = names_.find(name);
    if (found != names_.end()) return found->second;
    const auto index = static_cast<std::uint32_t>(content_.names.size());
    content_.names.emplace_back(name);
    names_.emplace(name, index);
    return index;
  }

  void start(const char* name, const char** attributes) {
    if (open_.size() >= XmlDocument::deepest)
      return stop("elements are nested more than " + std::to_string(XmlDocument::deepest) + " deep", "no model needs that");
    if (content_.nodes.size() >= XmlDocument::most_elements)
      return stop("more than " + std::to_string(XmlDocument::most_elements) + " elements", "no model is as large as that");
    const auto index = static_cast<std::uint32_t>(content_.nodes.size());
    XmlDocument::Node node;
    node.name = name_of(name);
    node.offset = static_cast<std::uint32_t>(offset());
    node.first_attribute = static_cast<std::uint32_t>(content_.attributes.size());
    for (const char** at = attributes; *at != nullptr; at += 2) {
      if (node.attributes == XmlDocument::most_at_once)
        return stop("more than " + std::to_string(XmlDocument::most_at_once) + " attributes in one element",
                    "no model is as large as that");
      const std::string_view value(at[1]);
      content_.attributes.push_back(
          {name_of(at[0]), static_cast<std::uint32_t>(content_.pool.size()), static_cast<std::uint32_t>(value.size())});
      content_.pool += value;
      ++node.attributes;
    }
    if (content_.attributes.size() > XmlDocument::most_attributes)
      return stop("more than " + std::to_string(XmlDocument::most_attributes) + " attributes", "no model is as large as that");
    if (!open_.empty()) {
      Open& parent = open_.back();
      close_text(parent);
      node.parent = parent.node;
      std::uint32_t& link = parent.last_child == XmlDocument::none ? content_.nodes[parent.node].first_child
                                                                   : content_.nodes[parent.last_child].next;
      link = index;
      parent.last_child = index;
    }
    content_.nodes.push_back(node);
    open_.push_back({index});
  }

  void end() {
    if (open_.empty()) return;
    close_text(open_.back());
    open_.pop_back();
  }

  // Text after the first child is layout.
  void add_text(std::string_view text) {
    if (open_.empty() || open_.back().last_child != XmlDocument::none) return;
    if (text_.empty()) {
      const std::size_t skipped = static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_blank) - text.begin());
      text.remove_prefix(skipped);
      if (text.empty()) return;
      content_.nodes[open_.back().node].text_offset = static_cast<std::uint32_t>(offset() + skipped);
    }
    text_ += text;
  }

  void close_text(const Open& open) {
    while (!text_.empty() && is_blank(text_.back())) text_.pop_back();
    if (text_.empty()) return;
    XmlDocument::Node& node = content_.nodes[open.node];
    node.text = static_cast<std::uint32_t>(content_.pool.size());
    node.text_size = static_cast<std::uint32_t>(text_.size());
    content_.pool += text_;
    text_.clear();
  }

  std::string opened() const {
    const XmlDocument::Node& node = content_.nodes[open_.back().node];
    return (quotes_ ? "<" + content_.names[node.name] + ">" : std::string("an element")) + ", opened on line " +
           std::to_string(document_.place_at(node.offset).line);
  }

  void explain() {
    const std::size_t size = content_.text.size();
    const XML_Error code = XML_GetErrorCode(parser_.get());
    error_.place = document_.place_at(std::min(offset(), size));
    switch (code) {
      case XML_ERROR_NO_ELEMENTS:
      case XML_ERROR_UNCLOSED_TOKEN:
      case XML_ERROR_UNCLOSED_CDATA_SECTION:
        if (open_.empty() && code == XML_ERROR_NO_ELEMENTS) {
          error_.what = "the file is empty: there is no element in it";
        } else {
          error_.what = open_.empty() ? "the file ends within a tag" : "the file ends within " + opened();
          error_.hint = "is it complete?";
        }
        break;
      case XML_ERROR_TAG_MISMATCH:
        error_.what = "this tag does not close " + (open_.empty() ? std::string("any open element") : opened());
        error_.hint = "every element is closed before the one that holds it";
        break;
      case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
        error_.what = "something follows the end of the document";
        error_.hint = "a file holds one root element";
        break;
      case XML_ERROR_DUPLICATE_ATTRIBUTE: error_.what = "an attribute is given twice in this tag"; break;
      case XML_ERROR_UNDEFINED_ENTITY:
        error_.what = "an entity that XML does not define";
        error_.hint = "XML defines &lt; &gt; &amp; &quot; and &apos;";
        break;
      case XML_ERROR_MISPLACED_XML_PI:
        error_.what = "<?xml …?> is allowed only at the very beginning of a file";
        error_.hint = "remove what is before it";
        break;
      case XML_ERROR_UNKNOWN_ENCODING:
      case XML_ERROR_INCORRECT_ENCODING: error_.what = "the text is not UTF-8"; break;
      default:
        error_.what = "cannot read this as XML: " + std::string(XML_ErrorString(code));
        if (size > 0 && content_.text.find('<') == std::string_view::npos) error_.hint = "this file contains no tags";
    }
  }

  struct StringHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view s) const { return std::hash<std::string_view>{}(s); }
  };

  XmlDocument& document_;
  Content& content_;
  SyntaxError& error_;
  bool quotes_;
  std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser_;
  std::exception_ptr failure_;  // of a callback
  std::vector<Open> open_;
  std::string text_;
  std::unordered_map<std::string, std::uint32_t, StringHash, std::equal_to<>> names_;
};

// Reserves as much as the text can contain: unused memory is never touched, and nothing is copied by growing.
void XmlDocument::reserve() {
  std::size_t tags = 0, values = 0;
  for (std::size_t i = 0; i + 1 < content_.text.size(); ++i) {
    if (content_.text[i] == '<' && content_.text[i + 1] != '/') ++tags;
    if (content_.text[i] == '=') ++values;
  }
  content_.nodes.reserve(std::min(tags, most_elements) + 1);
  content_.attributes.reserve(std::min(values, most_attributes) + 1);
  content_.pool.reserve(content_.text.size());
}

std::unique_ptr<const XmlDocument> XmlDocument::parse(std::string_view text, SyntaxError& error, bool quotes) {
  if (text.size() > (1u << 30)) {
    error = {{}, "more than 1 GiB, the limit for a model", ""};
    return nullptr;
  }
  if (auto problem = check_utf8(text)) {
    error = std::move(*problem);
    return nullptr;
  }
  std::unique_ptr<XmlDocument> document(new XmlDocument(text));
  document->reserve();
  document->marks_.reserve(text.size() / block + 1);
  document->marks_.push_back({});
  for (std::size_t i = 0; i + block <= text.size(); i += block)
    document->marks_.push_back(after(document->marks_.back(), text.substr(i, block)));
  error = {};
  if (!Builder(*document, error, quotes).build()) return nullptr;
  return document;
}

Place XmlDocument::place_at(std::size_t offset) const {
  offset = std::min(offset, content_.text.size());
  const std::size_t nearest = std::min(offset / block, marks_.size() - 1), from = nearest * block;
  Mark mark = after(marks_[nearest], content_.text.substr(from, offset - from));
  if (mark.line == 0 && mark.column > 0 && content_.text.starts_with("\xEF\xBB\xBF"))
    --mark.column;  // not a character of the line
  return {static_cast<int>(mark.line) + 1, static_cast<int>(mark.column) + 1, 0};
}

XmlDocument::Mark XmlDocument::after(Mark mark, std::string_view text) {
  for (const char c : text) {
    if (c == '\n')
      ++mark.line, mark.column = 0;
    else if ((static_cast<unsigned char>(c) & 0xc0) != 0x80)
      ++mark.column;
  }
  return mark;
}

std::string_view XmlElement::name() const { return document_->content().names[document_->content().nodes[index_].name]; }
std::string_view XmlElement::text() const {
  const auto& node = document_->content().nodes[index_];
  return document_->content().kept(node.text, node.text_size);
}
Place XmlElement::place() const { return document_->place_at(document_->content().nodes[index_].offset); }
Place XmlElement::text_place() const {
  const auto& node = document_->content().nodes[index_];
  return document_->place_at(node.text_size > 0 ? node.text_offset : node.offset);
}

namespace {
XmlElement element_or_none(const XmlDocument* document, std::uint32_t index) {
  return index == 0xffffffffu ? XmlElement{} : XmlElement{document, index};
}
}  // namespace

XmlElement XmlElement::parent() const { return element_or_none(document_, document_->content().nodes[index_].parent); }
XmlElement XmlElement::first_child() const { return element_or_none(document_, document_->content().nodes[index_].first_child); }
XmlElement XmlElement::next() const { return element_or_none(document_, document_->content().nodes[index_].next); }

std::size_t XmlElement::attributes() const { return document_->content().nodes[index_].attributes; }
std::string_view XmlElement::attribute_name(std::size_t i) const {
  return document_->content().names[document_->content().attributes[document_->content().nodes[index_].first_attribute + i].name];
}
std::string_view XmlElement::attribute(std::size_t i) const {
  const auto& attribute = document_->content().attributes[document_->content().nodes[index_].first_attribute + i];
  return document_->content().kept(attribute.value, attribute.size);
}
std::optional<std::size_t> XmlElement::find(std::string_view attribute) const {
  for (std::size_t i = 0; i < attributes(); ++i)
    if (attribute_name(i) == attribute) return i;
  return {};
}

// The parser reports only where a tag begins; its attributes follow there in order, and are well-formed.
Place XmlElement::attribute_place(std::size_t i, bool of_value) const {
  const std::string_view text = document_->content().text;
  const auto at = [&](std::size_t k) { return k < text.size() ? text[k] : '\0'; };
  std::size_t k = document_->content().nodes[index_].offset;
  while (k < text.size() && !is_blank(text[k]) && text[k] != '>') ++k;  // past the element's name
  for (std::size_t attribute = 0;; ++attribute) {
    while (is_blank(at(k))) ++k;
    const std::size_t name = k;
    while (k < text.size() && text[k] != '"' && text[k] != '\'' && text[k] != '>') ++k;
    if (k >= text.size() || text[k] == '>') return place();
    const std::size_t value = k + 1;
    if (attribute == i) return document_->place_at(of_value ? value : name);
    k = text.find(text[k], value);
    if (k == std::string_view::npos) return place();
    ++k;
  }
}

}  // namespace momentree::io
