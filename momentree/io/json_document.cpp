#include <momentree/io/json_document.hpp>

#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_set>

namespace momentree::io {

namespace {

// Reads the text for the parser, and counts the characters read: the parser itself reports no positions.
class Cursor {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  Cursor(const char* at, const char** reached) : at_(at), reached_(reached) {}
  reference operator*() const { return *at_; }
  Cursor& operator++() {
    ++at_;
    if (reached_ != nullptr) *reached_ = at_;
    return *this;
  }
  bool operator==(const Cursor& other) const { return at_ == other.at_; }
  bool operator!=(const Cursor& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** reached_;
};

struct Builder {
  using number_integer_t = nlohmann::json::number_integer_t;
  using number_unsigned_t = nlohmann::json::number_unsigned_t;
  using number_float_t = nlohmann::json::number_float_t;
  using string_t = nlohmann::json::string_t;
  using binary_t = nlohmann::json::binary_t;

  std::string_view text;
  JsonDocument& document;
  const char* reached;
  std::vector<JsonNode*> open{};
  std::vector<std::unordered_set<std::string>> keys{};
  bool after_key = false;
  // Positions only ever increase: lines are counted from the last one.
  std::size_t counted = 0, line_start = 0;
  int line = 1;

  // Sets the position of a node to `back` characters before that of the parser.
  void place(JsonNode& node, std::size_t back) {
    const auto here = static_cast<std::size_t>(reached - text.data());
    const std::size_t at = here > back ? here - back : 0;
    for (; counted < at && counted < text.size(); ++counted)
      if (text[counted] == '\n') ++line, line_start = counted + 1;
    node.line = line;
    node.column = static_cast<int>(at >= line_start ? at - line_start : 0) + 1;
  }
  JsonNode& add(JsonNode::Type type, std::size_t back) {
    JsonNode* node = &document.root;
    if (!open.empty()) {
      if (open.back()->is(JsonNode::Type::array))
        node = &open.back()->items.emplace_back();
      else
        node = &open.back()->members.back().value;
    }
    node->type = type;
    if (!after_key) place(*node, back);
    after_key = false;
    return *node;
  }
  bool begin(JsonNode::Type type) {
    JsonNode& node = add(type, 1);
    if (open.size() >= 64) document.fail_at(node, "this JSON is nested deeper than 64");
    open.push_back(&node);
    keys.emplace_back();
    return true;
  }
  bool end() {
    open.pop_back();
    keys.pop_back();
    return true;
  }

  bool null() { return add(JsonNode::Type::null, 4), true; }
  bool boolean(bool value) { return add(JsonNode::Type::boolean, value ? 4 : 5).number = value ? 1 : 0, true; }
  bool value(double number) { return add(JsonNode::Type::number, 2).number = number, true; }
  bool number_integer(number_integer_t number) { return value(static_cast<double>(number)); }
  bool number_unsigned(number_unsigned_t number) { return value(static_cast<double>(number)); }
  bool number_float(number_float_t number, const string_t&) { return value(number); }
  bool string(string_t& words) { return add(JsonNode::Type::string, words.size() + 2).text = words, true; }
  bool binary(binary_t&) { return false; }
  bool start_object(std::size_t) { return begin(JsonNode::Type::object); }
  bool end_object() { return end(); }
  bool start_array(std::size_t) { return begin(JsonNode::Type::array); }
  bool end_array() { return end(); }
  bool key(string_t& name) {
    open.back()->members.push_back({name, JsonNode{}});
    JsonNode& node = open.back()->members.back().value;
    place(node, name.size() + 2);
    if (!keys.back().insert(name).second) document.fail_at(node, "the key \"" + name + "\" is given twice");
    after_key = true;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
    JsonNode node;
    reached = text.data() + std::min(position, text.size());
    place(node, 1);
    std::string words = error.what();
    const std::size_t colon = words.find(": ");
    if (colon == std::string::npos) document.fail_at(node, "this is not JSON: a number is out of range");
    words.erase(0, colon + 2);
    // Any file may be named as a document, and the parser's message quotes the text: that part is cut off.
    const std::size_t text_at = words.find("; last read: "), expected = words.rfind("; expected ");
    if (text_at != std::string::npos)
      words.erase(text_at, expected != std::string::npos && expected > text_at ? expected - text_at : std::string::npos);
    document.fail_at(node, "this is not JSON: " + words);
  }
};

const char* const type_names[] = {"null", "true or false", "a number", "a string", "an array", "an object"};

const char* name_of(JsonNode::Type type) { return type_names[static_cast<std::size_t>(type)]; }

const JsonNode& require(const JsonDocument& document, const JsonNode& node, JsonNode::Type type, std::string_view what) {
  if (!node.is(type)) document.fail_at(node, std::string(what) + " should be " + name_of(type) + ", not " + name_of(node.type));
  return node;
}

}  // namespace

const JsonNode* JsonNode::find(std::string_view key) const {
  for (const auto& [name, node] : members)
    if (name == key) return &node;
  return nullptr;
}

std::string JsonDocument::where(const JsonNode& node) const {
  return file + ':' + std::to_string(node.line) + ':' + std::to_string(node.column);
}

void JsonDocument::fail_at(const JsonNode& node, std::string what, std::string hint) const {
  throw_error({std::move(what), where(node), std::move(hint)});
}

double JsonDocument::number(const JsonNode& node, std::string_view what) const {
  return require(*this, node, JsonNode::Type::number, what).number;
}
const std::string& JsonDocument::string(const JsonNode& node, std::string_view what) const {
  return require(*this, node, JsonNode::Type::string, what).text;
}
const JsonNode& JsonDocument::object(const JsonNode& node, std::string_view what) const {
  return require(*this, node, JsonNode::Type::object, what);
}
const JsonNode& JsonDocument::array(const JsonNode& node, std::string_view what) const {
  return require(*this, node, JsonNode::Type::array, what);
}

std::vector<double> JsonDocument::numbers(const JsonNode& node, std::string_view what) const {
  std::vector<double> values;
  for (const JsonNode& item : array(node, what).items) values.push_back(number(item, "each item of " + std::string(what)));
  return values;
}

void JsonDocument::require_known(const JsonNode& object, std::initializer_list<const char*> known) const {
  for (const auto& [key, node] : object.members) {
    bool found = false;
    for (const char* name : known) found = found || key == name;
    if (!found)
      fail_at(node, "unknown key \"" + key + "\"", did_you_mean(key, std::vector<std::string>(known.begin(), known.end())));
  }
}

JsonDocument parse_json(std::string_view text, std::string file) {
  JsonDocument document{std::move(file), {}};
  Builder builder{text, document, text.data()};
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {  // the parser would take it for the end
    builder.reached = text.data() + nul;
    builder.place(document.root, 0);
    document.fail_at(document.root, "this is not JSON: it contains a NUL character");
  }
  // Exceptions of `fail` pass through the parser, which holds only local variables.
  nlohmann::json::sax_parse(Cursor(text.data(), &builder.reached), Cursor(text.data() + text.size(), nullptr), &builder);
  return document;
}

}  // namespace momentree::io
