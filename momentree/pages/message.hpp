#pragma once
// A message of a page: a JSON object with its type (README.md lists them).
#include <optional>
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>
#include <momentree/math/vec.hpp>

namespace momentree::io {

/// Members are read by name, with a default if they may be absent. One that is absent or of another type refuses the message.
class Message {
 public:
  /// Throws Error for a text that is not JSON, which stops a build without exceptions.
  explicit Message(std::string_view text);

  const std::string& type() const { return type_; }
  std::string text(const char* key);
  bool flag(const char* key, std::optional<bool> absent = {});
  double number(const char* key, std::optional<double> absent = {});  ///< finite
  int index(const char* key);                                         ///< an integer that is not negative
  Vec3 vector(const char* key, std::optional<Vec3> absent = {});
  /// Null if it is absent.
  const Value& any(std::string_view key) const;

  /// Says why the message can't be carried out; the first reason counts.
  void refuse(std::string why);
  bool ok() const { return refusal_.empty(); }
  const std::string& refusal() const { return refusal_; }

 private:
  template <class T>
  T get(const char* key, std::optional<T> value, std::optional<T> absent, const char* expected);

  Value value_;
  std::string type_, refusal_;
};

/// A type of message, and what carries it out.
template <class Target>
struct MessageHandler {
  std::string_view type;
  void (*carry_out)(Target& target, Message& message);
};

/// Carries a message out by a table of handlers. False if it is not in the table.
template <class Target, std::size_t count>
bool carry_out(Message& message, Target& target, const MessageHandler<Target> (&handlers)[count]) {
  for (const MessageHandler<Target>& each : handlers)
    if (each.type == message.type()) return each.carry_out(target, message), true;
  return false;
}

/// {"type": …, key: json}
std::string message_json(std::string_view type, std::string_view key, std::string_view json);
/// {"type": …, "message": …}, such as "refused".
std::string report_json(std::string_view type, std::string_view message);

}  // namespace momentree::io
