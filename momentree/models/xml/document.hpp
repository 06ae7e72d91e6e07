#pragma once
// XML 1.0 text as elements with their lines and columns. The parser itself (expat) is in document.cpp alone.
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/text/syntax_error.hpp>

namespace momentree::io {

class XmlDocument;

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// The name in the first tag of a text, after comments and processing instructions; empty if anything else comes first.
std::string_view first_tag(std::string_view text);

/// One element of a document; cheap to copy. It is valid as long as its document exists and is not moved.
class XmlElement {
 public:
  XmlElement() = default;
  XmlElement(const XmlDocument* document, std::uint32_t index) : document_(document), index_(index) {}
  /// False for the result of an unsuccessful search.
  explicit operator bool() const { return document_ != nullptr; }
  friend bool operator==(const XmlElement&, const XmlElement&) = default;

  const XmlDocument* document() const { return document_; }
  std::string_view name() const;
  /// Characters before the first child, with entities resolved and surrounding blanks removed.
  std::string_view text() const;
  Place place() const;
  /// The place of the first character of text(), or of the element if it has none.
  Place text_place() const;
  XmlElement parent() const;
  XmlElement first_child() const;
  XmlElement next() const;

  std::size_t attributes() const;
  std::string_view attribute_name(std::size_t i) const;
  std::string_view attribute(std::size_t i) const;
  /// The place of the attribute's name, or of its value.
  Place attribute_place(std::size_t i, bool of_value = true) const;
  /// The index of an attribute in the element, if it has it.
  std::optional<std::size_t> find(std::string_view attribute) const;

  /// `<name>`, for messages.
  std::string tag() const { return "<" + std::string(name()) + ">"; }

  /// for (XmlElement child : element.children())
  class Range;
  Range children() const;

 private:
  const XmlDocument* document_ = nullptr;
  std::uint32_t index_ = 0;
};

class XmlElement::Range {
 public:
  class Iterator {
   public:
    explicit Iterator(XmlElement at) : at_(at) {}
    XmlElement operator*() const { return at_; }
    Iterator& operator++() {
      at_ = at_.next();
      return *this;
    }
    bool operator!=(const Iterator& other) const { return !(at_ == other.at_); }

   private:
    XmlElement at_;
  };
  explicit Range(XmlElement first) : first_(first) {}
  Iterator begin() const { return Iterator(first_); }
  Iterator end() const { return Iterator(XmlElement{}); }

 private:
  XmlElement first_;
};

inline XmlElement::Range XmlElement::children() const { return Range(first_child()); }

class XmlDocument {
 public:
  static constexpr std::size_t deepest = 1000, most_elements = 2'000'000, most_attributes = 4'000'000, most_at_once = 100'000;

  /// The document, or null with `error` set. `text` must outlive it and be UTF-8; a byte order mark and CRLF are accepted. In
  /// addition to invalid XML, these are refused: a document type (so that no entity is declared, expanded or fetched), and
  /// depths and numbers of elements and attributes (in total and per element) beyond any model. Time and memory are linear in
  /// the size of the text. `quotes`: the error may name elements.
  static std::unique_ptr<const XmlDocument> parse(std::string_view text, SyntaxError& error, bool quotes = true);

  XmlElement root() const { return {this, 0}; }
  Place place_at(std::size_t offset) const;

  static constexpr std::uint32_t none = 0xffffffffu;
  struct Node {
    std::uint32_t name = 0, offset = 0, parent = none, first_child = none, next = none;
    std::uint32_t first_attribute = 0, attributes = 0, text = 0, text_size = 0, text_offset = 0;
  };
  struct Attribute {
    std::uint32_t name = 0, value = 0, size = 0;
  };
  /// The document as it is stored, for XmlElement.
  struct Content {
    std::string_view text;
    std::string pool;  ///< all values and texts, concatenated
    std::vector<std::string> names;
    std::vector<Node> nodes;
    std::vector<Attribute> attributes;
    std::string_view kept(std::uint32_t at, std::uint32_t size) const { return std::string_view(pool).substr(at, size); }
  };
  const Content& content() const { return content_; }

 private:
  class Builder;
  explicit XmlDocument(std::string_view text) : content_{text, {}, {}, {}, {}} {}
  void reserve();

  Content content_;
  /// Line and column (from 0, in characters) at the start of every block of the text, so that places are found quickly even
  /// with long or many lines.
  static constexpr std::size_t block = 4096;
  struct Mark {
    std::uint32_t line = 0, column = 0;
  };
  static Mark after(Mark mark, std::string_view text);
  std::vector<Mark> marks_;
};

}  // namespace momentree::io
