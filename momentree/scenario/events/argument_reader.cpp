#include <momentree/scenario/events/argument_reader.hpp>

#include <momentree/scenario/events/argument_kinds.hpp>

namespace momentree::io {

ArgumentReader::ArgumentReader(const Value& from, WithArguments& of, TriggerMatch match, double of_event, Reading& all)
    : value(from),
      what(of),
      key(of.key()),
      reading(all),
      out(all.out),
      time(of_event),
      match_(std::move(match)),
      of_quantity_(dynamic_cast<const momentree::Quantity*>(&of) != nullptr) {
  int count = 0;
  what.arguments([&count](const Argument&) { ++count; });
  alone_ = of_quantity_ && count == 1;
}

bool ArgumentReader::read() {
  const std::size_t errors = out.errors();
  if (value.table() || what.plain_argument() != nullptr)
    what.arguments([this](const Argument& argument) { kind_of(argument).read(argument, *this); });
  else
    error(value, std::string("expected a table, found ") + value.type_name(), what.hint());
  if (fields_) fields_->finish();
  if (errors == out.errors() && !acts_.value_or(true)) error(value, "changes nothing", what.hint());
  return errors == out.errors();
}

Fields* ArgumentReader::table() {
  if (value.table() && !fields_) fields_.emplace(value, key, out);
  return fields_ ? &*fields_ : nullptr;
}

const Value* ArgumentReader::find(const char* argument, bool required) {
  if (Fields* fields = table()) return required ? fields->require(argument, what.hint()) : fields->find(argument);
  if (what.plain_argument() == std::string_view(argument)) return &value;
  if (required) error(value, "names no " + std::string(argument), what.hint());
  return nullptr;
}

std::optional<std::string> ArgumentReader::text(const Value* given, const char* argument) {
  if (given == nullptr) return {};
  return read_string(*given, fields_ && !of_quantity_ ? argument : key.c_str(), out);
}

}  // namespace momentree::io
