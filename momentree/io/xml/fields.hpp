#pragma once
// Attributes and children of one XML element: read with their types; what no reader asked for is said.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/io/xml/file.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io {

/// `count` finite numbers apart by blanks, in any locale; nothing, with a report under the name `label`, where there is something
/// else. `most` > `count`: so many may be given.
std::optional<std::vector<double>> read_numbers(std::string_view text, std::size_t count, std::size_t most, const XmlLocation& at,
                                                std::string_view label, XmlFile& file);

class XmlFields {
 public:
  XmlFields(XmlElement element, XmlFile& file) : element_(element), file_(file) {}

  XmlElement element() const { return element_; }
  bool has(std::string_view attribute) const { return element_.find(attribute).has_value(); }
  /// Of the attribute; of the element where it is absent.
  XmlLocation location(std::string_view attribute) const;

  /// Typed: nothing where the attribute is absent, or wrong and reported. The attribute is known from now on.
  std::optional<std::string> string(std::string_view attribute);
  std::optional<double> number(std::string_view attribute);
  std::optional<double> not_negative(std::string_view attribute);
  std::optional<double> positive(std::string_view attribute);
  std::optional<Vec3> vec3(std::string_view attribute);
  std::optional<std::vector<double>> numbers(std::string_view attribute, std::size_t count, std::size_t most = 0);
  /// true, false, 1 or 0
  std::optional<bool> boolean(std::string_view attribute);
  /// One of these names: its place among them. −1, with a report that lists them, where it is another, or absent: "unknown" and
  /// `what`, such as "type of joint".
  int require_choice(std::string_view attribute, const std::vector<std::string>& names, const std::string& what);
  /// The same, but absence is an error: to be called before the typed reading.
  bool require(std::string_view attribute, std::string hint = {});
  /// Known, and not asked for.
  void known(std::initializer_list<std::string_view> attributes);

  /// The child of that name, if there is one; a second one is an error. The name is known from now on.
  XmlElement child(std::string_view name);
  XmlElement require_child(std::string_view name, std::string hint = {});
  std::vector<XmlElement> children(std::string_view name);
  /// Known children that are left out: said once for the file, as a note; `why` is its hint.
  void leave_out(std::initializer_list<std::string_view> names, const std::string& why);
  void known_children(std::initializer_list<std::string_view> names);

  /// Unknown children, and all that belongs to another namespace, are left out with a note. An unknown attribute is a warning,
  /// and an error where a known one is absent and one or two letters away. To be called last.
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
