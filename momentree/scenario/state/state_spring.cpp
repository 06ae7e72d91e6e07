#include <momentree/scenario/state/state_spring.hpp>

#include <momentree/scenario/keys/described.hpp>

namespace momentree::io {

void read_spring_state(const Value::Entry& entry, const Model& model, Forest& forest, Diagnostics& out) {
  if (!model.has_spring(entry.key)) {
    std::vector<std::string> known;
    for (const Spring& spring : model.springs()) known.push_back(spring.name);
    return out.error(entry.place, "unknown spring " + in_quotes(entry.key), did_you_mean(entry.key, known));
  }
  const std::size_t errors = out.errors();
  const SpringId id = model.spring(entry.key);
  const Spring& declared = model.springs()[static_cast<std::size_t>(id.index)];
  Fields fields(entry.value, "spring " + in_quotes(entry.key), out, "");
  const bool broken = fields.boolean("broken").value_or(false);
  SpringLaw law = law_of(declared);
  MemberReader reader(fields);
  describe(reader, law);
  for (const char* result : {"length", "rate", "tension"}) fields.find(result);
  fields.finish();
  if (errors != out.errors()) return;
  for (SpringProblem& problem : check_spring(with_law(declared, law)))
    out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, std::move(problem.hint));
  if (errors == out.errors() && (broken || law != law_of(declared))) forest.springs.push_back({id.index, broken, law});
}

}  // namespace momentree::io
