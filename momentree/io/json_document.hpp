#pragma once
// JSON text as a tree of nodes with their positions in the text. (The parser itself stays in one .cpp file.)
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/error.hpp>

namespace momentree::io {

struct JsonMember;

struct JsonNode {
  enum class Type { null, boolean, number, string, array, object };
  Type type = Type::null;
  double number = 0;                ///< of a number; 1 for `true`
  std::string text;                 ///< of a string
  std::vector<JsonNode> items;      ///< of an array
  std::vector<JsonMember> members;  ///< of an object, in the order of the text; keys are unique
  int line = 1, column = 1;         ///< for a member: of its key

  bool is(Type t) const { return type == t; }
  /// The member of that name, or null.
  const JsonNode* find(std::string_view key) const;
};

struct JsonMember {
  std::string key;
  JsonNode value;
};

/// A JSON text with the name of its file, for messages.
struct JsonDocument {
  std::string file;
  JsonNode root;

  /// `file:line:col` of a node.
  std::string where(const JsonNode& node) const;
  /// Throws Error with the position of that node.
  [[noreturn]] void fail_at(const JsonNode& node, std::string what, std::string hint = "") const;

  /// The node as the given type; throws Error if it has another type. `what` names it in the message: "`time`".
  double number(const JsonNode& node, std::string_view what) const;
  const std::string& string(const JsonNode& node, std::string_view what) const;
  const JsonNode& object(const JsonNode& node, std::string_view what) const;
  const JsonNode& array(const JsonNode& node, std::string_view what) const;
  std::vector<double> numbers(const JsonNode& node, std::string_view what) const;
  /// Throws Error for a member whose key is not in `known`, with a suggestion.
  void require_known(const JsonNode& object, std::initializer_list<const char*> known) const;
};

/// Throws Error at the first mistake: syntax, a number too large for a double, a duplicate key, nesting deeper than 64.
JsonDocument parse_json(std::string_view text, std::string file);

}  // namespace momentree::io
