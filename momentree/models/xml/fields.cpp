#include <momentree/models/xml/fields.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

#include <momentree/base/edit_distance.hpp>
#include <momentree/base/error.hpp>

namespace momentree::io {

namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::vector<std::string_view> words_of(std::string_view text, std::size_t most) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < text.size() && words.size() < most;) {
    while (i < text.size() && is_blank(text[i])) ++i;
    const std::size_t begin = i;
    while (i < text.size() && !is_blank(text[i])) ++i;
    if (i > begin) words.push_back(text.substr(begin, i - begin));
  }
  return words;
}

struct Issue {
  std::string what, hint;
};

constexpr const char* expand = "expand the file first: xacro robot.urdf.xacro > robot.urdf";

// A part that xacro would replace. Definitions alone leave nothing out.
bool is_macro(std::string_view name) {
  return name.starts_with("xacro:") && name != "xacro:macro" && name != "xacro:property" && name != "xacro:arg";
}

// A finite number that is the whole word, in any locale.
std::optional<double> number_of(std::string_view word, Issue& issue) {
  std::string_view digits = word;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0;
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const std::string_view rest(end, static_cast<std::size_t>(digits.data() + digits.size() - end));
  if (code == std::errc::result_out_of_range && rest.empty()) {
    if (digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos) return 0.0;
    issue = {in_quotes(word) + " is out of range", ""};
    return {};
  }
  if (code == std::errc{} && rest.empty()) {
    if (std::isfinite(value)) return value;
    issue = {in_quotes(word) + " is not a finite number", ""};
    return {};
  }
  issue.what = in_quotes(word) + " is not a number";
  if (word.find("${") != std::string_view::npos || word.find("$(") != std::string_view::npos)
    issue.hint = expand;
  else if (!rest.empty() && rest[0] == ',')
    issue.hint = "use a point as the decimal sign, and separate numbers by blanks";
  else if (code == std::errc{} && !rest.empty() && is_letter(rest[0]))
    issue.hint = "units are not written here: values are in m, kg, s and units derived from them";
  return {};
}

// The name in `known` that differs by one or two letters; three-letter words must differ by one. In a file with many errors
// only a limited number of words are compared.
std::string slip_of(std::string_view word, const std::vector<std::string>& known, XmlFile& file) {
  if (known.empty() || !file.may_suggest()) return {};
  std::string meant;
  std::size_t best = 3;
  if (word.size() > 200) return meant;
  for (const std::string& candidate : known) {
    const std::size_t shorter = std::min(word.size(), candidate.size()), distance = edit_distance(word, candidate);
    if (distance < best && shorter > 2 && distance <= (shorter > 3 ? 2u : 1u)) best = distance, meant = candidate;
  }
  return meant;
}

}  // namespace

std::optional<std::vector<double>> read_numbers(std::string_view text, std::size_t count, std::size_t most, const XmlLocation& at,
                                                std::string_view label, XmlFile& file) {
  most = std::max(count, most);
  const std::vector<std::string_view> words = words_of(text, most + 1000);
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    Issue issue;
    const auto number = number_of(word, issue);
    if (!number) {
      file.error(at, std::string(label) + ": " + issue.what, issue.hint);
      return {};
    }
    numbers.push_back(*number);
    if (numbers.size() > most) break;
  }
  if (words.size() >= count && words.size() <= most) return numbers;
  const auto counted = [](std::size_t n) { return std::to_string(n) + (n == 1 ? " number" : " numbers"); };
  file.error(at,
             std::string(label) + ": expected " + (count == most ? "" : std::to_string(count) + " to ") + counted(most) +
                 ", found " + (words.empty() ? "none" : std::to_string(words.size())),
             words.size() > 1 ? "" : "separate numbers by blanks");
  return {};
}

XmlLocation XmlFields::location(std::string_view attribute) const {
  const auto i = element_.find(attribute);
  return {element_, i ? *i : XmlLocation::no_attribute};
}

void XmlFields::know(std::vector<std::string_view>& list, std::string_view name) {
  if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
}

std::optional<std::string> XmlFields::string(std::string_view attribute) {
  know(attributes_, attribute);
  const auto i = element_.find(attribute);
  if (!i) return {};
  return std::string(element_.attribute(*i));
}

std::optional<std::vector<double>> XmlFields::numbers(std::string_view attribute, std::size_t count, std::size_t most) {
  know(attributes_, attribute);
  const auto i = element_.find(attribute);
  if (!i) return {};
  return read_numbers(element_.attribute(*i), count, most, {element_, *i}, attribute, file_);
}

std::optional<double> XmlFields::number(std::string_view attribute) {
  const auto one = numbers(attribute, 1);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

std::optional<double> XmlFields::not_negative(std::string_view attribute) {
  const auto value = number(attribute);
  if (!value || *value >= 0) return value;
  file_.error(location(attribute), std::string(attribute) + ": must not be negative");
  return {};
}

std::optional<double> XmlFields::positive(std::string_view attribute) {
  const auto value = number(attribute);
  if (!value || *value > 0) return value;
  file_.error(location(attribute), std::string(attribute) + ": must be greater than 0");
  return {};
}

std::optional<Vec3> XmlFields::vec3(std::string_view attribute) {
  const auto three = numbers(attribute, 3);
  return three ? std::optional(Vec3{(*three)[0], (*three)[1], (*three)[2]}) : std::nullopt;
}

std::optional<bool> XmlFields::boolean(std::string_view attribute) {
  const auto text = string(attribute);
  if (!text) return {};
  if (*text == "true" || *text == "1") return true;
  if (*text == "false" || *text == "0") return false;
  file_.error(location(attribute), std::string(attribute) + ": expected true or false, found " + in_quotes(*text));
  return {};
}

bool XmlFields::require(std::string_view attribute, std::string hint) {
  know(attributes_, attribute);
  if (has(attribute)) return true;
  file_.error({element_}, element_.tag() + " has no '" + std::string(attribute) + "'", std::move(hint));
  return false;
}

int XmlFields::require_choice(std::string_view attribute, const std::vector<std::string>& names, const std::string& what) {
  std::string all = "one of:";
  for (const std::string& name : names) all += " " + name;
  if (!require(attribute, all)) return -1;
  const std::string given = string(attribute).value_or("");
  for (std::size_t i = 0; i < names.size(); ++i)
    if (given == names[i]) return static_cast<int>(i);
  const std::string hint = did_you_mean(given, names);
  file_.error(location(attribute), "unknown " + what + " " + in_quotes(given), hint.empty() ? all : hint);
  return -1;
}

void XmlFields::known(std::initializer_list<std::string_view> attributes) {
  for (const std::string_view name : attributes) know(attributes_, name);
}

XmlElement XmlFields::child(std::string_view name) {
  know(children_, name);
  XmlElement found{};
  for (const XmlElement each : element_.children()) {
    if (each.name() != name) continue;
    if (found) {
      file_.error({each}, "a second " + each.tag() + " in " + element_.tag() + ": the first is on " + file_.line_of(found),
                  "leave one of them out");
      break;
    }
    found = each;
  }
  return found;
}

XmlElement XmlFields::require_child(std::string_view name, std::string hint) {
  const XmlElement found = child(name);
  if (!found) file_.error({element_}, element_.tag() + " has no <" + std::string(name) + ">", std::move(hint));
  return found;
}

std::vector<XmlElement> XmlFields::children(std::string_view name) {
  know(children_, name);
  std::vector<XmlElement> found;
  for (const XmlElement each : element_.children())
    if (each.name() == name) found.push_back(each);
  return found;
}

void XmlFields::leave_out(std::initializer_list<std::string_view> names, const std::string& why) {
  known_children(names);
  for (const XmlElement each : element_.children())
    if (std::find(names.begin(), names.end(), each.name()) != names.end())
      file_.once(Severity::note, each.tag() + " is ignored", why, {each});
}

void XmlFields::known_children(std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) know(children_, name);
}

void XmlFields::finish() {
  finish_attributes();
  finish_children();
}

void XmlFields::finish_attributes() {
  std::optional<std::vector<std::string>> absent;  // computed once, if needed
  for (std::size_t i = 0; i < element_.attributes(); ++i) {
    const std::string_view name = element_.attribute_name(i);
    if (std::find(attributes_.begin(), attributes_.end(), name) != attributes_.end()) continue;
    if (name == "xmlns" || name.starts_with("xmlns:") || name.starts_with("xml:")) continue;
    const XmlLocation location{element_, i, false, true};
    if (name.find(':') != std::string_view::npos) {
      file_.once(Severity::note, "attribute " + in_quotes(name) + " of " + element_.tag() + " is ignored",
                 "it belongs to another namespace", location);
      continue;
    }
    if (!absent) {
      absent.emplace();
      for (const std::string_view each : attributes_)
        if (!has(each)) absent->emplace_back(each);
    }
    const std::string meant = slip_of(name, *absent, file_);
    if (!meant.empty())
      file_.error(location, "unknown attribute " + in_quotes(name) + " of " + element_.tag(), "did you mean '" + meant + "'?");
    else
      file_.once(Severity::note, "unknown attribute " + in_quotes(name) + " of " + element_.tag() + " is ignored", "", location);
  }
}

void XmlFields::finish_children() {
  const std::vector<std::string> known(children_.begin(), children_.end());
  for (const XmlElement each : element_.children()) {
    const std::string_view name = each.name();
    if (std::find(children_.begin(), children_.end(), name) != children_.end()) continue;
    if (is_macro(name)) {
      file_.error({each}, each.tag() + " is not expanded: what it stands for is missing", expand);
      continue;
    }
    std::string hint;
    if (name.find(':') != std::string_view::npos) {
      hint = "it belongs to another namespace";
    } else if (const std::string meant = slip_of(name, known, file_); !meant.empty()) {
      hint = "did you mean <" + meant + ">?";
    }
    // A misspelled name that matters should not hide among what is ignored on purpose.
    file_.once(hint.starts_with("did") ? Severity::warning : Severity::note, each.tag() + " in " + element_.tag() + " is ignored",
               hint, {each});
  }
}

}  // namespace momentree::io
