#pragma once
// Reads attributes and children of one XML element with their types, and reports those that no reader requests.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/math/vec.hpp>
#include <momentree/models/xml/file.hpp>

namespace momentree::io {

/// `count` finite numbers separated by blanks, independent of the locale; nothing, with a report under the name `label`, if the
/// text is anything else. If `most` > `count`, up to `most` numbers are allowed.
std::optional<std::vector<double>> read_numbers(std::string_view text, std::size_t count, std::size_t most, const XmlLocation& at,
                                                std::string_view label, XmlFile& file);

class XmlFields {
 public:
  XmlFields(XmlElement element, XmlFile& file) : element_(element), file_(file) {}

  XmlElement element() const { return element_; }
  bool has(std::string_view attribute) const { return element_.find(attribute).has_value(); }
  /// The place of the attribute, or of the element if it is absent.
  XmlLocation location(std::string_view attribute) const;

  /// Typed values: nothing if the attribute is absent, or if it is wrong and was reported. The attribute is known from now on.
  std::optional<std::string> string(std::string_view attribute);
  std::optional<double> number(std::string_view attribute);
  std::optional<double> not_negative(std::string_view attribute);
  std::optional<double> positive(std::string_view attribute);
  std::optional<Vec3> vec3(std::string_view attribute);
  std::optional<std::vector<double>> numbers(std::string_view attribute, std::size_t count, std::size_t most = 0);
  /// true, false, 1 or 0
  std::optional<bool> boolean(std::string_view attribute);
  /// The index of the attribute's value in `names`. If it is another value or absent, returns −1 and reports "unknown" and
  /// `what`, such as "type of joint", with a list of the names.
  int require_choice(std::string_view attribute, const std::vector<std::string>& names, const std::string& what);
  /// A missing attribute is an error. Call it before the typed reader.
  bool require(std::string_view attribute, std::string hint = {});
  /// Marks attributes as known although they are not read.
  void known(std::initializer_list<std::string_view> attributes);

  /// The child of that name, if it exists; a second one is an error. The name is known from now on.
  XmlElement child(std::string_view name);
  XmlElement require_child(std::string_view name, std::string hint = {});
  std::vector<XmlElement> children(std::string_view name);
  /// Known children that are ignored: reported once per file, as a note; `why` is its hint.
  void leave_out(std::initializer_list<std::string_view> names, const std::string& why);
  void known_children(std::initializer_list<std::string_view> names);

  /// Ignores unknown children, and everything in another namespace, with a note. An unknown attribute is a warning; it is an
  /// error if it differs by one or two letters from a known attribute that is absent. Call it last.
  void finish();

 private:
  void finish_attributes();
  void finish_children();
  void know(std::vector<std::string_view>& list, std::string_view name);

  XmlElement element_;
  XmlFile& file_;
  std::vector<std::string_view> attributes_, children_;  // names are literals
};

}  // namespace momentree::io
