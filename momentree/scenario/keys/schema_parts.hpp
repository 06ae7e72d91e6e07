#pragma once
// The parts of the schema of scenarios. Internal to its generator: other code uses schema.hpp.
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <momentree/scenario/keys/joint_keys.hpp>
#include <momentree/scenario/keys/keys.hpp>
#include <momentree/simulate/events/argument.hpp>

namespace momentree::io::schema {

using Json = nlohmann::ordered_json;

/// A number, or a string with a unit.
inline Json a_number() { return {{"type", {"number", "string"}}}; }
inline Json a_name() { return {{"type", "string"}}; }
Json list_of(const Json& items, int least, int most);
Json either(Json one, Json other);
/// A table with these keys alone.
Json table_of(std::string about, Json properties, const std::vector<std::string>& required);
/// Adds bounds for numbers; they do not apply to strings.
void bound(Range range, Json& number);

/// The schema of a file with these keys, as text.
std::string document(const char* title, const KeyTable& keys);

class Schema {
 public:
  /// The schema of a file with these keys.
  Json whole(const char* title, const KeyTable& keys) {
    Json all{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title}};
    all.update(in_place(keys));
    all["definitions"] = definitions_;
    return all;
  }

  /// A table, or a reference to its definition.
  Json table(const KeyTable& keys);
  /// Add a key, or the parameters of a joint, to the properties of a table.
  void add(const Key& key, Json& properties);
  void add_parameters(Json& properties) { add(joint_keys(), properties); }

 private:
  Json in_place(const KeyTable& keys);
  Json table_of_arguments(WithArguments& what);
  void add_actions(Json& properties);
  void add_quantities(Json& properties);
  Json of_type(const Type& type, std::string& about);
  void add(std::span<const JointKey> keys, Json& properties);
  Json group(const JointGroup& group, const std::string& about);
  Json signal();
  void add_numbers(std::span<const SignalKey> keys, bool defaults, Json& properties);

  Json definitions_ = Json::object();
};

}  // namespace momentree::io::schema
