// [[loop]]: joints that close kinematic loops.
#include <string>
#include <vector>

#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/scenario/state/changed_start.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/events/strengths.hpp>
#include <momentree/simulate/singular_start.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key loop_entries[] = {
    {"name", string, "Name of the joint, among all joints of the scenario", nullptr,
     "a name, by which events and results refer to it"},
    {"body", string, "Full name of the body that is the joint's child", nullptr, "a body, for example \"arm/hand\""},
    {"to", string, "Full name of the body that is its parent; \"ground\", or no key: the ground"},
    {"at", table(placement_table), "Placement of the joint's frame in the frame of `to`"},
    {"child_at", table(placement_table), "Placement of the joint's frame in the body's frame"},
    {"assemble", boolean, "Whether the loop is closed at the start by changing the initial values; else they must close it",
     "true"},
};

constexpr long most_rows = 5000, most_columns = 4'000'000;

void report_loop(const std::string& loop, std::string what, std::string hint, Reading& reading) {
  if (const auto spots = reading.from_model.find(loop); spots != reading.from_model.end())
    spots->second.file->error({spots->second.joint}, std::move(what), std::move(hint));
  else
    reading.out.error(reading.joints.at(loop), std::move(what), std::move(hint));
}

void report_coupling(std::size_t coupling, std::string what, std::string hint, Reading& reading) {
  const CouplingPlace& place = reading.exact_places[coupling];
  if (place.file != nullptr)
    place.file->error({place.element}, std::move(what), std::move(hint));
  else
    reading.out.error(place.place, std::move(what), std::move(hint));
}

/// The body of that name; nothing, with a report, if there is none.
std::optional<BodyId> body_named(const Value& value, const char* key, const std::string& loop, bool may_be_ground,
                                 Reading& reading) {
  const auto name = read_string(value, key, reading.out);
  if (!name || reading.opaque.contains(mechanism_of(*name))) return std::nullopt;
  if (may_be_ground && *name == "ground") return ground;
  if (!reading.bodies.contains(*name)) {
    std::string hint = reading.suggest(*name, reading.bodies);
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (hint.empty() && reading.bodies.contains(mechanism + "/" + *name))
        hint = "use the full name: " + in_quotes(mechanism + "/" + *name);
    reading.out.error(value.place, "loop " + in_quotes(loop) + ": " + key + ": there is no body " + in_quotes(*name), hint);
    return std::nullopt;
  }
  const Model& model = reading.scenario.model;
  return model.has_body(*name) ? std::optional(model.body(*name)) : std::nullopt;  // else of a mechanism with errors
}

bool names_ground(const Value& value) { return value.string() != nullptr && *value.string() == "ground"; }

/// The ground as the child of a loop joint: what to write instead.
void report_child(const Value& body, const Value* to, const std::string& loop, Reading& reading) {
  const bool both = to == nullptr || names_ground(*to);
  const std::string other = !both && to->string() != nullptr ? in_quotes(*to->string()) : "the other body";
  reading.out.error(
      body.place,
      "loop " + in_quotes(loop) + ": body: " + (both ? "both ends are the ground" : "the ground can't be the child of a joint"),
      both ? "name a body here; leave 'to' out for a joint to the ground"
           : "write body = " + other + ", leave 'to' out, and exchange 'at' and 'child_at'");
}

}  // namespace

constinit const KeyTable loop_table{"[[loop]]", "loop", "A joint that closes a loop", loop_entries, {}, {&loop_geometry}, true};

void read_loop(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  Fields fields(table, loop_table, out);
  LoopSpec spec;
  fields.require("name");
  spec.name = fields.string("name").value_or("");
  if (!spec.name.empty()) reading.note(reading.joints, spec.name, fields.place_of("name"), "joint");
  const Value* body = fields.require("body");
  const bool may_be_child = body != nullptr && !names_ground(*body);
  const std::optional<BodyId> child = may_be_child ? body_named(*body, "body", spec.name, false, reading) : std::nullopt;
  const Value* to = fields.find("to");
  const std::optional<BodyId> parent = to ? body_named(*to, "to", spec.name, true, reading) : std::optional(ground);
  if (body != nullptr && names_ground(*body)) report_child(*body, to, spec.name, reading);
  spec.at = fields.pose("at").value_or(Pose{});
  spec.child_at = fields.pose("child_at").value_or(Pose{});
  spec.assemble = fields.boolean("assemble").value_or(true);
  const Value* kind = fields.find("kind");
  if (kind != nullptr && kind->string() != nullptr && *kind->string() == "free")
    return out.error(kind->place, "loop " + in_quotes(spec.name) + ": a free joint constrains nothing, so it can't close a loop",
                     "use any other kind");
  JointDescription joint;
  read_description(fields, false, joint, out);
  spec.joint = joint.spec;
  fields.finish();
  if (!child || !parent || errors != out.errors()) return;
  spec.body = *child, spec.to = *parent;
  for (const BodyProblem& problem : check_loop(spec, reading.scenario.model.size()))
    out.error(fields.place_of(problem.field), "loop " + in_quotes(spec.name) + ": " + problem.field + ": " + problem.what,
              problem.hint);
  if (errors == out.errors()) reading.scenario.model.add_loop(std::move(spec));
}

bool loops_fit(Reading& reading) {
  const Model& model = reading.scenario.model;
  if (!has_equations(model)) return true;
  std::vector<long> depth;  // number of bodies from the ground
  depth.reserve(static_cast<std::size_t>(model.size()));
  const auto depth_of = [&depth](BodyId body) { return body == ground ? 0 : depth[static_cast<std::size_t>(body.index)]; };
  for (const BodySpec& body : model.bodies()) depth.push_back(depth_of(body.parent) + 1);
  long rows = 0, columns = 0;
  for (const LoopSpec& loop : model.loops()) {
    const long own = 6 - info(loop.joint.kind).nv;
    rows += own, columns += own * (depth_of(loop.body) + depth_of(loop.to));
    if (rows <= most_rows && columns <= most_columns) continue;
    report_loop(loop.name,
                rows > most_rows ? "a scenario has loops of at most " + std::to_string(most_rows) + " equations in total"
                                 : "the loops are too long: their equations concern too many bodies",
                "they are solved together, which would need too much memory", reading);
    return false;
  }
  for (std::size_t c = 0; c < model.couplings().size(); ++c) {
    const Coupling& coupling = model.couplings()[c];
    rows += 1,
        columns += depth_of(model.child(coupling.joint)) + (coupling.leads() ? depth_of(model.child(coupling.follows)) : 0);
    if (rows <= most_rows && columns <= most_columns) continue;
    report_coupling(c,
                    rows > most_rows ? "a scenario has loops and couplings of at most " + std::to_string(most_rows) + " equations"
                                     : "the equations of couplings and loops concern too many bodies",
                    "they are solved together, which would need too much memory", reading);
    return false;
  }
  return true;
}

namespace {

void warn_of_singular_start(const World& world, Reading& reading) {
  const std::vector<JointId> singular = singular_loops(world);
  if (singular.empty()) return;
  std::string names;
  for (const JointId loop : singular) names += (names.empty() ? "" : ", ") + in_quotes(std::string(world.joint_name(loop)));
  const auto place = reading.joints.find(std::string(world.joint_name(singular.front())));
  reading.out.warning(place == reading.joints.end() ? Place{} : place->second,
                      "the start is a singular position of loop " + names +
                          ": it blocks fewer directions there than nearby, so the mechanism can go on in different ways",
                      "give start values away from it, for example bars that do not lie in one line");
}

void warn_of_changed_start(const World& world, Reading& reading) {
  const std::optional<ChangedStart> changed = changed_start(world);
  if (!changed) return;
  const auto place = reading.joints.find(std::string(world.joint_name(changed->joint)));
  reading.out.warning(place == reading.joints.end() ? Place{} : place->second, changed->what, changed->hint);
}

void check_strengths(const World& world, Reading& reading) {
  const std::optional<Error> error = undetermined_strength(world);
  if (!error) return;
  for (const auto& [joint, place] : reading.joints)
    if (error->where == "joint '" + joint + "'") reading.out.error(place, error->where + ": " + error->problem, error->hint);
}

}  // namespace

void check_loops(Reading& reading) {
  const Model& model = reading.scenario.model;
  if (!has_equations(model)) return;
  Integration& how = reading.scenario.integration;
  how.variables = how.loop_variables();
  const std::optional<Error> error = check_assembly(model);
  if (!error) {
    const World world(model, Variables::velocities);
    if (reading.scenario.state_files.empty()) warn_of_singular_start(world, reading), warn_of_changed_start(world, reading);
    return check_strengths(world, reading);
  }
  for (const LoopSpec& loop : model.loops())
    if (error->where == "loop '" + loop.name + "'")
      return report_loop(loop.name, error->where + ": " + error->problem, error->hint, reading);
  for (std::size_t c = 0; c < model.couplings().size(); ++c) {
    const Coupling& coupling = model.couplings()[c];
    const std::string follows = coupling.leads() ? model[coupling.follows].joint_name : std::string();
    if (error->where != "coupling of " + coupling_text(coupling, model[coupling.joint].joint_name, follows)) continue;
    return report_coupling(c, error->where + ": " + error->problem, error->hint, reading);
  }
  for (const auto& [joint, place] : reading.joints)
    if (error->where == "joint '" + joint + "'")
      return reading.out.error(place, error->where + ": " + error->problem, error->hint);
  const std::string problem = error->where + ": " + error->problem;
  if (model.loops().empty())
    report_coupling(0, problem, error->hint, reading);
  else
    report_loop(model.loops().front().name, problem, error->hint, reading);
}

}  // namespace momentree::io
