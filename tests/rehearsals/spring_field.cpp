// Compiled with spring_field.patch: the new field reaches every visitor of springs.
#include <cstdio>
#include <string_view>

#include <momentree/scenario/keys/described.hpp>
#include <momentree/text/archive.hpp>
#include <momentree/text/json.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

int failures = 0;
void check(bool holds, const char* what) {
  if (!holds) std::printf("the field does not reach %s\n", what), ++failures;
}

}  // namespace

int main() {
  Spring spring{.name = "tie"};
  spring.stiffness = 2, spring.rest = 1, spring.preload = 3;
  const SpringLaw law = law_of(spring);
  check(law.tension(1, 0) == 3 && with_law({}, law).preload == 3, "the law");

  bool key = false;
  for (const Key& each : keys_of<Spring>()) key = key || each.name == std::string_view("preload");
  check(key, "the keys of [[spring]]");

  const Model model;
  const Value table(TableWriter(model).of(spring), Place{});
  const Value::Entry* const written = table.find("preload");
  check(written != nullptr && written->value.number() == 3.0, "convert");

  std::string text;
  JsonWriter json(text);
  json.begin_object();
  MemberWriter members(json, model);
  describe(members, law);
  json.end_object();
  Diagnostics out("a document", text);
  const Value document = parse_json(text, "a document");
  Fields fields(document, "a spring", out, "");
  SpringLaw read;
  MemberReader in_document(fields);
  describe(in_document, read);
  fields.finish();
  check(out.errors() == 0 && read == law, "documents");

  ArchiveWriter writer;
  writer(law);
  ArchiveReader reader(writer.bytes, "an archive");
  SpringLaw restored;
  reader(restored);
  check(restored == law, "checkpoints");
  return failures;
}
