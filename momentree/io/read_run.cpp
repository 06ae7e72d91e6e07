// [world], [integrate] and [output].
#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

void read_world(const Value& table, Reading& reading) {
  Fields fields(table, "[world]", reading.out);
  if (const auto gravity = fields.vec3("gravity", dimension::acceleration)) reading.scenario.model.set_gravity(*gravity);
  fields.finish();
}

void read_integrate(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, "[integrate]", out);
  Integration& integration = reading.scenario.integration;
  if (const auto method = fields.string("method")) {
    const std::vector<std::string> later{"dopri5", "dop853", "midpoint", "damped"},
        all{"rk4", "dopri5", "dop853", "midpoint", "damped"};
    if (std::find(later.begin(), later.end(), *method) != later.end())
      out.error(fields.place_of("method"), "method " + in_quotes(*method) + " is not supported yet", "this version has \"rk4\"");
    else if (*method != "rk4") {
      const std::string hint = did_you_mean(*method, all);
      out.error(fields.place_of("method"), "unknown method " + in_quotes(*method),
                hint.empty() ? "this version has \"rk4\"" : hint);
    }
  }
  integration.step = fields.positive("step", dimension::time).value_or(integration.step);
  integration.event_tolerance = fields.positive("event_tolerance", dimension::time).value_or(integration.event_tolerance);
  reading.scenario.until = fields.not_negative("until", dimension::time).value_or(reading.scenario.until);
  fields.later({"rtol", "atol", "max_step"});
  fields.finish();
}

void read_output(const Value& table, Reading& reading) {
  Fields fields(table, "[output]", reading.out);
  reading.scenario.output_every = fields.not_negative("every", dimension::time).value_or(0);
  fields.finish();
}

}  // namespace momentree::io
