#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/results/compare/parts.hpp>
#include <momentree/text/diagnostic.hpp>
#include <momentree/text/files/line_reader.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

std::string value_text(const Value& value) {
  if (const auto number = value.number()) return number_text(*number);
  if (const std::string* words = value.string()) return in_quotes(*words);
  if (const bool* truth = value.boolean()) return *truth ? "true" : "false";
  return value.type_name();
}

// The first place in which two values differ, as a path: "joints", "arm/elbow", "q", "0".
class ValueComparison {
 public:
  explicit ValueComparison(double tolerance) : tolerance_(tolerance) {}
  std::vector<std::string> path;
  std::string one, other;

  bool differ(const Value& a, const Value& b) {
    if (const auto x = a.number(), y = b.number(); x && y) return !near_enough(*x, *y, tolerance_) && note(a, b);
    if (a.string() != nullptr && b.string() != nullptr) return *a.string() != *b.string() && note(a, b);
    if (a.boolean() != nullptr && b.boolean() != nullptr) return *a.boolean() != *b.boolean() && note(a, b);
    if (a.is_null() && b.is_null()) return false;
    if (a.array() != nullptr && b.array() != nullptr) return lists_differ(*a.array(), *b.array());
    if (a.table() != nullptr && b.table() != nullptr) return tables_differ(a, b);
    return note(a, b);
  }
  bool tables_differ(const Value& a, const Value& b, std::string_view without = {}) {
    for (const Value::Entry& entry : *a.table()) {
      if (entry.key == without) continue;
      const Value::Entry* const same = b.find(entry.key);
      path.push_back(entry.key);
      if (same == nullptr) return one = value_text(entry.value), true;
      if (differ(entry.value, same->value)) return true;
      path.pop_back();
    }
    for (const Value::Entry& entry : *b.table()) {
      if (entry.key == without || a.find(entry.key) != nullptr) continue;
      path.push_back(entry.key);
      return other = value_text(entry.value), true;
    }
    return false;
  }

 private:
  bool note(const Value& a, const Value& b) {
    one = value_text(a), other = value_text(b);
    return true;
  }
  bool lists_differ(const Value::Array& a, const Value::Array& b) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
      path.push_back(std::to_string(i));
      if (i >= a.size()) return other = value_text(b[i]), true;
      if (i >= b.size()) return one = value_text(a[i]), true;
      if (differ(a[i], b[i])) return true;
      path.pop_back();
    }
    return false;
  }

  double tolerance_;
};

std::string path_text(const std::vector<std::string>& path, std::size_t from = 0) {
  std::string text;
  for (std::size_t i = from; i < path.size(); ++i) text += (i > from ? " " : "") + path[i];
  return text;
}

std::string both_text(const std::string& one, const std::string& other) {
  if (one.empty()) return "absent in the first run, " + other + " in the second";
  if (other.empty()) return one + " in the first run, absent in the second";
  return one + " and " + other;
}

}  // namespace

void compare_documents(const Compared& folders, const char* file, const char* without, std::vector<Difference>& found) {
  const bool one = is_there(folders.one / file), other = is_there(folders.other / file);
  if (!one && !other) return;
  Difference difference{.kind = Difference::Kind::document, .file = file};
  if (one != other) {
    difference.what =
        "only the " + std::string(one ? "first" : "second") + " folder has this file: the other run did not come to its end";
    found.push_back(std::move(difference));
    return;
  }
  const std::string text = read_text_file((folders.one / file).string()),
                    text_2 = read_text_file((folders.other / file).string());
  if (text == text_2) return;
  const Value a = parse_json(text, (folders.one / file).string()), b = parse_json(text_2, (folders.other / file).string());
  ValueComparison values(folders.tolerance);
  const bool objects = a.table() != nullptr && b.table() != nullptr;
  if (!(objects ? values.tables_differ(a, b, without) : values.differ(a, b))) return;
  const bool named = values.path.size() > 1;  // bodies and joints are members of lists by name
  difference.name = named ? values.path[1] : "";
  difference.column = path_text(values.path, named ? 2 : 0);
  difference.one = values.one, difference.other = values.other;
  difference.what = path_text(values.path) + ": " + both_text(values.one, values.other);
  found.push_back(std::move(difference));
}

std::size_t compare_events(const Compared& folders, const TableEnds& ends, std::vector<Difference>& found) {
  const char* const file = "events.jsonl";
  const std::string names[] = {(folders.one / file).string(), (folders.other / file).string()};
  LineReader readers[] = {LineReader(names[0]), LineReader(names[1])};
  std::string lines[2];
  for (std::size_t count = 0;; ++count) {
    bool there[2];
    Value events[2];
    for (std::size_t i : {0, 1}) there[i] = readers[i].next(lines[i]) && readers[i].is_whole();
    if (!there[0] && !there[1]) return count;
    if (there[0] && there[1] && lines[0] == lines[1]) continue;
    Difference difference{.file = file, .row = count + 1};
    for (std::size_t i : {0, 1}) {
      if (!there[i]) continue;
      events[i] = parse_json(lines[i], names[i] + ':' + std::to_string(readers[i].number()));
      const Value::Entry *time = events[i].find("time"), *name = events[i].find("event");
      if (time == nullptr || !time->value.number() || name == nullptr || name->value.string() == nullptr)
        throw_error({"this is no event", names[i] + ':' + std::to_string(readers[i].number()),
                     "give a folder that `momentree run` wrote"});
      if (!difference.time || *time->value.number() < *difference.time)
        difference.time = time->value.number(), difference.name = *name->value.string();
    }
    if (!there[0] || !there[1]) {
      if (*difference.time > (there[0] ? ends.other : ends.one)) return count;  // after the end of the shorter run
      difference.what =
          "only the " + std::string(there[0] ? "first" : "second") + " run has the event " + in_quotes(difference.name);
      found.push_back(std::move(difference));
      return count;
    }
    ValueComparison values(folders.tolerance);
    if (!values.tables_differ(events[0], events[1], "duration_ns")) continue;
    difference.column = path_text(values.path);
    difference.one = values.one, difference.other = values.other;
    difference.what =
        "event " + in_quotes(difference.name) + ", " + difference.column + ": " + both_text(values.one, values.other);
    found.push_back(std::move(difference));
    return count;
  }
}

}  // namespace momentree::io
