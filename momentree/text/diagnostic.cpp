#include <momentree/text/diagnostic.hpp>

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include <momentree/base/characters.hpp>

namespace momentree::io {

namespace {

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

// At most `most` characters; never cut within a character.
std::string_view shortened(std::string_view text, std::size_t most) {
  std::size_t characters = 0, i = 0;
  for (; i < text.size(); ++i)
    if (!continues_character(text[i]) && ++characters > most) break;
  return text.substr(0, i);
}

constexpr std::size_t source_width = 120;

// In the order of the file, options last.
bool before(const Place& a, const Place& b) {
  return std::tuple(a.option, a.line, a.column) < std::tuple(b.option, b.line, b.column);
}

}  // namespace

Error Diagnostic::error() const {
  std::string where = file;
  if (line > 0) where += ":" + std::to_string(line);
  if (line > 0 && column > 0) where += ":" + std::to_string(column);
  return {what, std::move(where), hint};
}

std::string Diagnostic::message() const {
  std::string text = printable(error().where);
  text += ": " + std::string(word_of(severity)) + ": " + printable(what);
  if (!hint.empty()) text += "; " + printable(hint);
  return text;
}

std::string Diagnostic::rendered() const {
  std::string text = message() + "\n";
  if (source.empty() || line == 0) return text;
  const std::string_view shown = shortened(source, source_width);
  const std::string number = std::to_string(line), margin(std::max<std::size_t>(number.size(), 4) + 1, ' ');
  text += std::string(margin.size() - number.size(), ' ') + number + " | ";
  std::string blanks;  // up to the caret; an escaped character takes several columns of the terminal
  int at = 0;
  for (std::size_t i = 0; i < shown.size();) {
    at += !continues_character(shown[i]);
    const std::size_t begin = text.size();
    i += append_printable(text, shown, i);
    for (std::size_t k = begin; k < text.size() && at < column; ++k)
      if (!continues_character(text[k])) blanks += text[k] == '\t' ? '\t' : ' ';
  }
  text += shown.size() < source.size() ? " …\n" : "\n";
  if (column < 1 || static_cast<std::size_t>(column) > source_width + 1) return text;
  return text + margin + " | " + blanks + "^\n";
}

bool has_errors(const std::vector<Diagnostic>& diagnostics) {
  return std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) { return d.severity == Severity::error; });
}

const char* word_of(Severity severity) {
  constexpr const char* words[] = {"error", "warning", "note"};
  return words[static_cast<int>(severity)];
}

std::string rendered(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const Diagnostic& d : diagnostics) text += d.rendered();
  return text;
}

namespace {

std::string all_of(const std::vector<Diagnostic>& diagnostics) {
  std::string text = rendered(diagnostics);
  if (!text.empty()) text.pop_back();
  return text;
}

Error first_error(const std::vector<Diagnostic>& diagnostics) {
  for (const Diagnostic& d : diagnostics)
    if (d.severity == Severity::error) return d.error();
  return {"", "", ""};
}

}  // namespace

InputError::InputError(std::vector<Diagnostic> all) : InputError(first_error(all), std::move(all)) {}
InputError::InputError(Error first, std::vector<Diagnostic>&& all)
    : Error(std::move(first.problem), std::move(first.where), std::move(first.hint), all_of(all)), diagnostics(std::move(all)) {}

Diagnostics::Diagnostics(std::string file, std::string_view text, std::vector<std::string> options)
    : file_(std::move(file)), text_(text), options_(std::move(options)) {}

std::string_view Diagnostics::line_text(int line) {
  if (line < 1) return {};
  constexpr std::size_t every = 64;  // the start of every 64th line is stored
  if (line_starts_.empty()) {        // computed once, when there is something to report
    line_starts_.push_back(0);
    std::size_t lines = 0;
    for (std::size_t i = text_.find('\n'); i != std::string_view::npos; i = text_.find('\n', i + 1))
      if (++lines % every == 0) line_starts_.push_back(i + 1);
  }
  const auto index = static_cast<std::size_t>(line) - 1;
  if (index / every >= line_starts_.size()) return {};
  std::string_view rest = text_.substr(line_starts_[index / every]);
  for (std::size_t k = index % every; k > 0; --k) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) return {};
    rest.remove_prefix(end + 1);
  }
  if (index == 0 && rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);  // columns do not count a byte order mark
  rest = rest.substr(0, rest.find('\n'));
  if (!rest.empty() && rest.back() == '\r') rest.remove_suffix(1);
  return rest;
}

void Diagnostics::add(Severity severity, Place place, std::string what, std::string hint) {
  std::size_t first = diagnostics_.size();
  for (std::size_t i = diagnostics_.size(); i-- > 0;) {
    const Diagnostic& d = diagnostics_[i];
    if (d.severity != severity || d.what != what) continue;
    if (places_[i] == place && place != Place{}) return;  // found by several readers of one value
    if (d.hint == hint && d.line > 0 && place.line > 0) first = i;
  }
  if (severity == Severity::error) ++errors_;
  if (first < diagnostics_.size()) {
    Equal& equal = equal_[first];
    if (before(place, equal.first)) equal.first = place;
    if (before(equal.last, place)) equal.last = place;
    if (++equal.count > most_equal) return;
  }
  const auto kind = static_cast<std::size_t>(severity);
  if (kept_[kind]++ >= most) {
    ++dropped_[kind];
    return;
  }
  Diagnostic d{severity, file_, place.line, place.column, std::move(what), std::move(hint), {}};
  if (place.option > 0) {
    d.file = name_of(place);
    d.line = d.column = 0;
  } else {
    d.source = line_text(place.line).substr(0, 4 * source_width + 4);
  }
  diagnostics_.push_back(std::move(d));
  places_.push_back(place);
  equal_.push_back({1, place, place});
}

std::string Diagnostics::name_of(Place place) const {
  if (place.option > 0 && static_cast<std::size_t>(place.option) <= options_.size())
    return "--set " + std::string(shortened(options_[static_cast<std::size_t>(place.option) - 1], 80));
  return "line " + std::to_string(place.line);
}

void Diagnostics::throw_first() {
  if (errors_ == 0) return;
  for (const Diagnostic& each : take())
    if (each.severity == Severity::error) throw_error(each.error());
}

// More than a few equal ones become one, at the first place.
void Diagnostics::unite_equal() {
  std::vector<char> gone(diagnostics_.size(), 0);
  for (std::size_t i = 0; i < diagnostics_.size(); ++i) {
    const Equal& equal = equal_[i];
    if (equal.count <= most_equal) continue;
    Diagnostic& d = diagnostics_[i];
    for (std::size_t k = i + 1; k < diagnostics_.size(); ++k) {
      const Diagnostic& other = diagnostics_[k];
      if (other.line > 0 && other.severity == d.severity && other.what == d.what && other.hint == d.hint) gone[k] = 1;
    }
    places_[i] = equal.first;
    d.line = equal.first.line, d.column = equal.first.column;
    d.source = line_text(d.line).substr(0, 4 * source_width + 4);
    d.what += " (and " + std::to_string(equal.count - 1) + " times more, up to line " + std::to_string(equal.last.line) + ")";
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (gone[i] != 0) continue;
    if (kept != i) diagnostics_[kept] = std::move(diagnostics_[i]), places_[kept] = places_[i];
    ++kept;
  }
  diagnostics_.resize(kept);
  places_.resize(kept);
}

std::vector<Diagnostic> Diagnostics::take() {
  unite_equal();
  std::vector<std::size_t> order(diagnostics_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return before(places_[a], places_[b]); });
  std::vector<Diagnostic> sorted;
  for (const std::size_t i : order) sorted.push_back(std::move(diagnostics_[i]));
  const char* const further[] = {" or more further errors", " more warnings", " more notes"};
  for (const Severity severity : {Severity::error, Severity::warning, Severity::note})
    if (const auto kind = static_cast<std::size_t>(severity); dropped_[kind] > 0)
      sorted.push_back({severity, file_, 0, 0, "and " + std::to_string(dropped_[kind]) + further[kind], "", ""});
  diagnostics_.clear();
  places_.clear();
  equal_.clear();
  return sorted;
}

std::string in_quotes(std::string_view name) {
  const std::string_view shown = shortened(name, 60);
  return "'" + printable(shown) + (shown.size() < name.size() ? "…'" : "'");
}

bool check_bare_name(const std::string& name, Place place, std::string_view what, Diagnostics& out) {
  const auto refuse = [&](const char* why, const char* hint) {
    out.error(place, "name: " + std::string(what) + " cannot be named " + in_quotes(name) + ": " + why, hint);
    return false;
  };
  if (name.empty()) return refuse("it is empty", "");
  if (name.size() > 200) return refuse("it is longer than 200 characters", "");
  if (name == "ground") return refuse("it means the ground", "");
  if (name == "." || name == "..") return refuse("it means a folder", "");
  if (name.front() == '#') return refuse("# begins the numbers of events", "");
  if (first_invisible(name) != std::string::npos)
    return refuse("it has an invisible character", "a name has no control characters, direction marks and the like");
  if (name.find_first_of("/,\"*") != std::string::npos)
    return refuse("it has a character that is not allowed", "a name has no / , \" * and no control characters");
  return true;
}

}  // namespace momentree::io
