// Checks that steps, tolerances and the length of a run are consistent, and suitable for the model.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/stiffness.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

// Checking larger models would take longer than a user waits.
constexpr int most_bodies = 20'000;
constexpr double many_steps = 1e9, many_numbers = 1e10;

std::string text(double x) { return rounded_text(x, 3); }

class IntegrationChecker {
 public:
  explicit IntegrationChecker(Reading& reading)
      : scenario_(reading.scenario), how_(scenario_.integration), at_(reading.integrate), out_(reading.out) {}

  void times() const {
    const double until = scenario_.until;
    const bool adaptive = is_adaptive(how_.method);
    const double longest = adaptive ? how_.max_step : how_.step, apart = std::nextafter(until, HUGE_VAL) - until;
    const char* const key = adaptive ? "max_step" : "step";
    if (until > 0 && longest < apart) {
      out_.error(adaptive ? at_.max_step : at_.step,
                 std::string(key) + " = " + text(longest) + " s is below the resolution of the clock: at the end of the run, " +
                     text(until) + " s, instants are " + text(apart) + " s apart",
                 "use a longer step, or a shorter run");
      return;
    }
    if (!adaptive && until > 0 && how_.step > until)
      out_.warning(at_.step, "step = " + text(how_.step) + " s is longer than the whole run of " + text(until) + " s",
                   "a step resolves the fastest motion: \"1 ms\" is usual");
    if (until / longest > many_steps)
      out_.warning(
          until / how_.step > many_steps && at_.step == Place{} ? at_.until
          : adaptive                                            ? at_.max_step
                                                                : at_.step,
          "the run takes " + text(until / longest) + " steps or more: " + text(until) + " s in steps of " + text(longest) + " s",
          "use a longer step, or a shorter run");
    else
      rows(adaptive);
    if (!adaptive && scenario_.output_every > 0 && scenario_.output_every < how_.step * (1 - 1e-9))
      out_.warning(at_.every,
                   "every = " + text(scenario_.output_every) + " s is shorter than the step of " + text(how_.step) +
                       " s: steps end at rows, so they will be as short",
                   "give step = " + text(scenario_.output_every) + ", or a longer interval between rows");
    if (at_.event_tolerance == Place{}) return;
    if (how_.event_tolerance >= how_.step && !adaptive)
      out_.warning(
          at_.event_tolerance,
          "event_tolerance = " + text(how_.event_tolerance) + " s is as long as a step: the instants of events are not located",
          "1e-10 s is the default");
    else if (until > 0 && how_.event_tolerance >= until)
      out_.warning(at_.event_tolerance, "event_tolerance = " + text(how_.event_tolerance) + " s is as long as the run",
                   "1e-10 s is the default");
  }

  void tolerances() const {
    if (!is_adaptive(how_.method)) return;
    constexpr double loose = 0.05;
    if (how_.rtol > loose)
      out_.warning(at_.rtol,
                   "rtol = " + text(how_.rtol) + " allows an error per step of " + text(100 * how_.rtol) + " % of the motion",
                   "1e-6 to 1e-10 is usual");
    if (how_.atol > loose)
      out_.warning(at_.atol,
                   "atol = " + text(how_.atol) + " allows an error per step of " + text(how_.atol) + " rad or m, rad/s or m/s",
                   "1e-6 to 1e-12 is usual");
    // A velocity near zero has no significant digits: its error is the rounding error of the others.
    constexpr double least = 1e-18;
    if (how_.atol < least)
      out_.warning(at_.atol,
                   "atol = " + text(how_.atol) +
                       " is below the rounding error of a velocity near zero: steps shrink without limit if anything is at rest",
                   "use 1e-15 or more; `rtol` controls the error of moving bodies");
  }

  void model() const {
    const Model& model = scenario_.model;
    if (model.size() == 0 || model.size() > most_bodies || is_adaptive(how_.method) || !(scenario_.until > 0)) return;
    // Changes of the world by a document or an event before the first step are not known here.
    const auto at_start = [](const ScenarioEvent& event) { return !event.condition && event.after.empty() && event.time == 0; };
    if (!scenario_.state_files.empty() || std::any_of(scenario_.events.begin(), scenario_.events.end(), at_start)) return;
    const Tree& tree = model.compiled();
    if (tree.nv() == 0) return;
    State state = start_state(model, tree, tree.has_loops() ? how_.loop_variables() : Variables::momenta);
    if (tree.has_loops() && assemble(tree, model, Names(model), state, given_start(model, tree)))
      return;  // a mistake that check_loops reports
    const double step = std::min(how_.step, scenario_.until);
    if (const auto stiff = too_stiff(tree, state.q(), how_.method, step)) {
      const bool closes = is_loop({stiff->joint});
      const std::string& name = closes ? model.loops()[static_cast<std::size_t>(stiff->joint - first_loop)].name
                                       : model[BodyId{stiff->joint}].joint_name;
      out_.warning(at_.step, stiff->what(name, step) + " by " + how_.method, stiff->cure());
    } else if (const auto spring = too_stiff_spring(tree, state.q(), how_.method, step)) {
      const std::string& name = model.springs()[static_cast<std::size_t>(spring->spring)].name;
      out_.warning(at_.step, spring->what(name, step) + " by " + how_.method, spring->cure());
    } else {
      first_step(tree, state, step);
    }
  }

 private:
  void rows(bool adaptive) const {
    const double every = scenario_.output_every > 0 ? scenario_.output_every : adaptive ? HUGE_VAL : how_.step;
    const double numbers = scenario_.until / every * 13 * scenario_.model.size();  // of bodies.csv, and as many of joints.csv
    if (numbers < many_numbers) return;
    out_.warning(at_.every == Place{} ? at_.until : at_.every,
                 "the tables would hold " + text(scenario_.until / every) + " rows of " + std::to_string(scenario_.model.size()) +
                     " bodies: about " + text(numbers * 18e-9) + " GB",
                 "use a longer interval between rows: [output] every = \"" + text(scenario_.until / 1000) + " s\"");
  }

  // Compares the first step with two half steps: if they differ much, the step cannot resolve the motion.
  void first_step(const Tree& tree, State& state, double step) const {
    constexpr double far = 0.05;  // rad
    Workspace<double> work(tree);
    State halves = state;
    const bool whole_good = stepped(tree, work, state, step, 1), halves_good = stepped(tree, work, halves, step / 2, 2);
    double worst = 0;
    int joint = -1;
    for (const int b : tree.order()) {
      const KindInfo& kind = info(tree.kind(b));
      for (int i = 0; i < kind.nq; ++i) {
        const auto k = static_cast<std::size_t>(tree.first_q(b) + i);
        const double apart = kind.q_units[i] == 'm' ? 0 : std::fabs(state.q()[k] - halves.q()[k]);
        if (apart > worst) worst = apart, joint = tree.joint_of(b);
      }
    }
    if (whole_good && halves_good && worst <= far) return;
    std::string what = "step = " + text(step) + " s is too long for this motion: ";
    if (joint >= 0 && whole_good && halves_good)
      what += "the first step of joint '" + scenario_.model[BodyId{joint}].joint_name + "' is off by " + text(worst) + " rad";
    else
      what += "the first step runs away";
    out_.warning(at_.step, what,
                 "use a smaller one, such as " + text(step / 20) + ", or method = \"dopri5\", which chooses its steps");
  }

  bool stepped(const Tree& tree, Workspace<double>& work, State& state, double h, int times) const {
    Evaluator evaluate(tree, work);
    EnergyLedger ledger;
    const auto method = make_integrator(how_.method, tree, {h, how_.rtol, how_.atol, how_.max_step});
    for (int i = 0; i < times; ++i) {
      evaluate(state);
      if (!method->step(evaluate, state, ledger, h)) return false;
    }
    return true;
  }

  const Scenario& scenario_;
  const Integration& how_;
  const IntegratePlaces& at_;
  Diagnostics& out_;
};

}  // namespace

void check_integration(Reading& reading) {
  const std::size_t errors = reading.out.errors();
  const IntegrationChecker checker(reading);
  checker.times();
  checker.tolerances();
  if (errors == reading.out.errors()) checker.model();
  if (reading.scenario.integration.variables == Variables::momenta && reading.scenario.model.has_contact())
    reading.out.warning(reading.integrate.variables, "variables: worlds with contact or cables are integrated in velocities",
                        "leave it out");
}

}  // namespace momentree::io
