// [world], [integrate] and [output].
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/simulate/arguments.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key world_entries[] = {
    {"gravity", vector(dimension::acceleration), "Gravity", "[0, 0, -9.81]"},
    {"floor", other(R"({"anyOf": [{"type": "boolean"}, @]})", floor_table), "A plane that bodies with a collision touch",
     "false"},
    {"collision", one_or_several(ground_shape_table), "Planes and solids that bodies with a collision touch, fixed in the world"},
};
std::vector<std::string> ways_to_share() { return {"together", "in_turn"}; }

constexpr Key integrate_entries[] = {
    {"method", choice(&method_names), "Integration method", R"("rk4")"},
    {"variables", choice(&variable_names), "What the state holds between events; default: what suits the method",
     R"("velocities")"},
    {"step", number(dimension::time, Range::positive), "Step; for adaptive methods the first one", "0.001"},
    {"event_tolerance", number(dimension::time, Range::positive), "Accuracy of located instants", "1e-10"},
    {"until", number(dimension::time, Range::not_negative), "End of the run", "10"},
    {"rtol", number(dimension::number, Range::positive), "Adaptive methods: relative error per step", "1e-8"},
    {"atol", number(dimension::number, Range::positive), "Adaptive methods: absolute error per step", "1e-10"},
    {"max_step", number(dimension::time, Range::positive),
     "The longest step of adaptive methods, and of the motion between impulses with stepping; default: no limit"},
    {"simultaneous", choice(&ways_to_share), "How contacts that close at one instant share the impact", R"("together")"},
    {"resolve", boolean, "Bodies that overlap at the start are pushed apart, with the least motion", "false"},
};

constexpr Key output_entries[] = {
    {"every", number(dimension::time, Range::not_negative), "Time between rows of the tables; 0: every step", "0"}};

}  // namespace

constinit const KeyTable world_table{"[world]", "", "The world", world_entries};
constinit const KeyTable integrate_table{"[integrate]", "", "Integration", integrate_entries};
constinit const KeyTable output_table{"[output]", "", "Output", output_entries};

void read_world(const Value& table, Reading& reading) {
  Fields fields(table, world_table, reading.out);
  if (const auto gravity = fields.vec3("gravity")) {
    if (std::isfinite(norm(*gravity)))
      reading.scenario.model.set_gravity(*gravity);
    else
      reading.out.error(fields.place_of("gravity"), "gravity: its magnitude is beyond the range of numbers");
  }
  if (const Value* floor = fields.find("floor")) read_floor(*floor, reading);
  if (const Value* collision = fields.find("collision")) read_ground(*collision, reading);
  fields.finish();
}

namespace {

// Time is a double: instants closer to each other than its resolution cannot be distinguished.
void check_event_tolerance(double tolerance, Place place, Reading& reading) {
  const double end = reading.scenario.until, apart = std::nextafter(end, HUGE_VAL) - end;
  if (tolerance >= 4 * apart) return;
  char text[160], hint[80];
  std::snprintf(
      text, sizeof text,
      "event_tolerance = %.3g s is below the resolution of the clock: at the end of the run, %.6g s, instants are %.2g s apart",
      tolerance, end, apart);
  std::snprintf(hint, sizeof hint, "use %.0e s or more", 10 * apart);
  reading.out.warning(place, text, hint);
}

}  // namespace

void read_integrate(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, integrate_table, out);
  Integration& integration = reading.scenario.integration;
  if (const auto method = fields.string("method")) {
    const std::vector<std::string> known = integration_methods();
    const auto in = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), *method) != names.end();
    };
    std::string all;
    for (const std::string& name : known) all += (all.empty() ? "this version has \"" : ", \"") + name + '"';
    if (in(method_names())) {
      integration.method = method_named(*method);
    } else {
      std::string hint = cure_of_method(*method);
      if (hint.empty()) hint = did_you_mean(*method, known);
      out.error(fields.place_of("method"), "unknown method " + in_quotes(*method), hint.empty() ? all : hint);
    }
  }
  if (const auto name = fields.string("variables")) {
    integration.variables = variables_of(*name);
    if (!integration.variables)
      out.error(fields.place_of("variables"), "unknown variables " + in_quotes(*name), did_you_mean(*name, variable_names()));
    else if (*integration.variables == Variables::velocities && !takes_velocities(integration.method))
      out.error(fields.place_of("variables"), "method " + in_quotes(integration.method) + " integrates momenta",
                "leave out variables, or use another method");
  }
  integration.resolve = fields.boolean("resolve").value_or(integration.resolve);
  if (const auto how = fields.string("simultaneous")) {
    if (*how != "together" && *how != "in_turn")
      out.error(fields.place_of("simultaneous"), "simultaneous: expected \"together\" or \"in_turn\", not " + in_quotes(*how));
    else if (*how == "in_turn")
      integration.simultaneous = contact::Simultaneous::in_turn;
  }
  integration.step = fields.number("step").value_or(integration.step);
  integration.event_tolerance = fields.number("event_tolerance").value_or(integration.event_tolerance);
  reading.scenario.until = fields.number("until").value_or(reading.scenario.until);
  integration.rtol = fields.number("rtol").value_or(integration.rtol);
  integration.atol = fields.number("atol").value_or(integration.atol);
  integration.max_step = fields.number("max_step").value_or(integration.max_step);
  if (!is_adaptive(integration.method))
    for (const char* key : {"rtol", "atol", "max_step"})
      if (fields.has(key) && !(key == std::string_view("max_step") && steps_through_contacts(integration.method)))
        out.warning(fields.place_of(key),
                    in_quotes(key) + " has no effect: method " + in_quotes(integration.method) + " has fixed steps",
                    "use method = \"dopri5\", which chooses its steps");
  if (fields.has("event_tolerance"))
    check_event_tolerance(integration.event_tolerance, fields.place_of("event_tolerance"), reading);
  reading.integrate = {fields.place_of("step"),     fields.place_of("until"),
                       fields.place_of("rtol"),     fields.place_of("atol"),
                       fields.place_of("max_step"), fields.has("event_tolerance") ? fields.place_of("event_tolerance") : Place{},
                       reading.integrate.every,     fields.has("variables") ? fields.place_of("variables") : Place{}};
  fields.finish();
}

void check_tolerance(Reading& reading) {
  const Integration& integration = reading.scenario.integration;
  if (!is_adaptive(integration.method)) return;
  double resolved = 0x1p-53;
  if (integration.state_variables(reading.scenario.model) == Variables::momenta) {
    const Tree& tree = reading.scenario.model.compiled();
    resolved = velocity_resolution(tree, start_state(reading.scenario.model, tree).q());
  }
  if (integration.rtol >= 10 * resolved) return;
  char text[64], mend[64];
  std::snprintf(text, sizeof text, "rtol = %.3g is below", integration.rtol);
  std::snprintf(mend, sizeof mend, "%.1g: use rtol = %.0e or more", resolved, 10 * resolved);
  reading.out.warning(reading.integrate.rtol, std::string(text) + " the resolution of the velocities of this mechanism",
                      std::string("they are known to about ") + mend);
}

void read_output(const Value& table, Reading& reading) {
  Fields fields(table, output_table, reading.out);
  if (const auto every = fields.number("every")) {
    reading.scenario.output_every = *every;
    reading.integrate.every = fields.place_of("every");
    const std::optional<Error> wrong =
        *every > 0 ? wrong_period(*every, reading.scenario.integration.step, "every: a period") : std::nullopt;
    if (wrong) reading.out.error(fields.place_of("every"), wrong->problem, wrong->hint);
  }
  fields.finish();
}

}  // namespace momentree::io
