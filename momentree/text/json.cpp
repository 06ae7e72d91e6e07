#include <momentree/text/json.hpp>

#include <cstddef>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_set>
#include <utility>
#include <vector>

#include <momentree/base/error.hpp>

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

class Builder {
 public:
  using number_integer_t = nlohmann::json::number_integer_t;
  using number_unsigned_t = nlohmann::json::number_unsigned_t;
  using number_float_t = nlohmann::json::number_float_t;
  using string_t = nlohmann::json::string_t;
  using binary_t = nlohmann::json::binary_t;

  Builder(std::string_view text, const std::string& file) : reached(text.data()), text_(text), file_(file) {}
  const char* reached;
  Value root;

  bool null() { return add(Value::Null{}); }
  bool boolean(bool value) { return add(value); }
  bool number_integer(number_integer_t number) { return add(std::int64_t{number}); }
  bool number_unsigned(number_unsigned_t number) {
    if (number > static_cast<number_unsigned_t>(std::numeric_limits<std::int64_t>::max()))
      return add(static_cast<double>(number));
    return add(static_cast<std::int64_t>(number));
  }
  bool number_float(number_float_t number, const string_t&) { return add(number); }
  bool string(string_t& words) { return add(std::move(words)); }
  bool binary(binary_t&) { return false; }
  bool start_object(std::size_t) { return begin(Value::Table{}); }
  bool end_object() { return end(); }
  bool start_array(std::size_t) { return begin(Value::Array{}); }
  bool end_array() { return end(); }
  bool key(string_t& name) {
    const Place place = next_place();
    if (!keys_.back().insert(name).second) fail(place, "the key \"" + name + "\" is given twice");
    open_.back()->table()->push_back({std::move(name), place, {}});
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
    const std::size_t end = std::min(position, text_.size());
    const Place place = place_of(end > 0 ? end - 1 : 0);
    std::string words = error.what();
    const std::size_t colon = words.find(": ");
    if (colon == std::string::npos) fail(place, "this is not JSON: a number is out of range");
    words.erase(0, colon + 2);
    const std::size_t text_at = words.find("; last read: "), expected = words.rfind("; expected ");
    if (text_at != std::string::npos)  // the text
      words.erase(text_at, expected != std::string::npos && expected > text_at ? expected - text_at : std::string::npos);
    fail(place, "this is not JSON: " + words);
  }
  /// Positions only ever increase: lines are counted from the last one.
  Place place_of(std::size_t position) {
    for (; counted_ < position && counted_ < text_.size(); ++counted_) {
      const bool continues = (static_cast<unsigned char>(text_[counted_]) & 0xc0) == 0x80;
      if (text_[counted_] == '\n')
        ++line_, column_ = 1;
      else
        column_ += !continues;
    }
    return {line_, column_, 0};
  }
  [[noreturn]] void fail(const Place& place, std::string what) const {
    throw_error({std::move(what), file_ + ':' + std::to_string(place.line) + ':' + std::to_string(place.column), ""});
  }

 private:
  // The place of the token that was just read: the first one after the token before.
  Place next_place() {
    const auto end = static_cast<std::size_t>(reached - text_.data());
    const std::size_t begin = text_.find_first_not_of(" \t\r\n,:", read_);
    read_ = end;
    return place_of(std::min(begin, end));
  }
  template <class T>
  bool add(T data) {
    place(Value(std::move(data), next_place()));
    return true;
  }
  Value& place(Value value) {
    if (open_.empty()) return root = std::move(value);
    if (Value::Array* entries = open_.back()->array()) return entries->emplace_back(std::move(value));
    return open_.back()->table()->back().value = std::move(value);
  }
  template <class T>
  bool begin(T data) {
    Value& value = place(Value(std::move(data), next_place()));
    if (open_.size() >= 64) fail(value.place, "this JSON is nested deeper than 64");
    open_.push_back(&value);
    keys_.emplace_back();
    return true;
  }
  bool end() {
    next_place();
    open_.pop_back();
    keys_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& file_;
  std::vector<Value*> open_;
  std::vector<std::unordered_set<std::string>> keys_;
  std::size_t read_ = 0, counted_ = 0;
  int line_ = 1, column_ = 1;
};

}  // namespace

Value parse_json(std::string_view text, const std::string& file) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  Builder builder(text, file);
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos)  // the parser would take it for the end
    builder.fail(builder.place_of(nul), "this is not JSON: it contains a NUL character");
  // Exceptions of `fail` pass through the parser, which holds only local variables.
  nlohmann::json::sax_parse(Cursor(text.data(), &builder.reached), Cursor(text.data() + text.size(), nullptr), &builder);
  return std::move(builder.root);
}

}  // namespace momentree::io
