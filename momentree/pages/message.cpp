#include <momentree/pages/message.hpp>

#include <cmath>

#include <momentree/text/json.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {

namespace {

std::optional<double> finite(const Value& value) {
  const std::optional<double> number = value.number();
  return number && std::isfinite(*number) ? number : std::nullopt;
}

template <class T>
std::optional<T> copy_of(const T* value) {
  return value != nullptr ? std::optional<T>(*value) : std::nullopt;
}

}  // namespace

Message::Message(std::string_view text) : value_(parse_json(text, "message")) { type_ = this->text("type"); }

const Value& Message::any(std::string_view key) const {
  static const Value none(Value::Null{}, {});
  const Value::Entry* const found = value_.find(key);
  return found != nullptr ? found->value : none;
}

template <class T>
T Message::get(const char* key, std::optional<T> value, std::optional<T> absent, const char* expected) {
  if (!value && value_.find(key) == nullptr) value = absent;
  if (!value) refuse("message '" + type_ + "': " + key + " must be " + expected);
  return std::move(value).value_or(T{});
}

void Message::refuse(std::string why) {
  if (ok()) refusal_ = std::move(why);
}

std::string Message::text(const char* key) { return get<std::string>(key, copy_of(any(key).string()), {}, "a text"); }
bool Message::flag(const char* key, std::optional<bool> absent) {
  return get(key, copy_of(any(key).boolean()), absent, "true or false");
}
double Message::number(const char* key, std::optional<double> absent) {
  return get(key, finite(any(key)), absent, "a finite number");
}

int Message::index(const char* key) {
  const std::int64_t* const number = any(key).integer();
  const bool valid = number != nullptr && *number >= 0 && *number < 2'000'000'000;
  return get<int>(key, valid ? std::optional(static_cast<int>(*number)) : std::nullopt, {}, "a number from 0 on");
}

Vec3 Message::vector(const char* key, std::optional<Vec3> absent) {
  const Value::Array* const items = any(key).array();
  std::optional<Vec3> result;
  if (items != nullptr && items->size() == 3) {
    const auto x = finite((*items)[0]), y = finite((*items)[1]), z = finite((*items)[2]);
    if (x && y && z) result = Vec3{*x, *y, *z};
  }
  return get(key, result, absent, "three finite numbers");
}

std::string message_json(std::string_view type, std::string_view key, std::string_view json) {
  std::string text;
  JsonWriter(text).begin_object().member("type", type).key(key).raw(json).end_object();
  return text;
}

std::string report_json(std::string_view type, std::string_view message) {
  std::string text;
  JsonWriter(text).value(message);
  return message_json(type, "message", text);
}

}  // namespace momentree::io
