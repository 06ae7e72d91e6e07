#include <momentree/io/state_spring.hpp>

namespace momentree::io {

void read_spring_state(const Value::Entry& entry, const Model& model, Forest& forest, Diagnostics& out) {
  if (!model.has_spring(entry.key)) {
    std::vector<std::string> known;
    for (const Spring& spring : model.springs()) known.push_back(spring.name);
    return out.error(entry.place, "unknown spring " + in_quotes(entry.key), did_you_mean(entry.key, known));
  }
  const std::size_t errors = out.errors();
  const SpringId id = model.spring(entry.key);
  Spring spring = model.springs()[static_cast<std::size_t>(id.index)];
  Fields fields(entry.value, "spring " + in_quotes(entry.key), out, "");
  const bool broken = fields.boolean("broken").value_or(false);
  spring.stiffness = fields.real("stiffness").value_or(spring.stiffness);
  spring.rest = fields.real("rest").value_or(*spring.rest);
  spring.damping = fields.real("damping").value_or(spring.damping);
  spring.tension_only = fields.boolean("tension_only").value_or(spring.tension_only);
  const Value* const strength = fields.find("strength");
  if (strength != nullptr) spring.strength = strength->is_null() ? HUGE_VAL : fields.real("strength").value_or(HUGE_VAL);
  for (const char* result : {"length", "rate", "tension"}) fields.find(result);
  fields.finish();
  if (errors != out.errors()) return;
  for (SpringProblem& problem : check_spring(spring))
    out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, std::move(problem.hint));
  const SpringLaw law = law_of(spring);
  const SpringLaw declared = law_of(model.springs()[static_cast<std::size_t>(id.index)]);
  if (errors == out.errors() && (broken || law != declared)) forest.springs.push_back({id.index, broken, law});
}

}  // namespace momentree::io
