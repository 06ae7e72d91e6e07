#include <tests/fuzz/scenario_laws.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/actions/impulse.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/fuzz/instant_laws.hpp>
#include <tests/fuzz/same_text.hpp>

namespace momentree::fuzz {

namespace {

constexpr long most_steps = 20'000;

/// A text as if it were a file of this folder, where the mesh is that it may name.
io::ReadResult read_text(const std::string& text) {
  return io::read_scenario_from(text, MOMENTREE_MESHES "/random.toml", "random", MOMENTREE_MESHES);
}

/// A refusal has a location and a reason.
void check_refusal(const io::ReadResult& result, Findings& found) {
  found.require(io::has_errors(result.diagnostics), "a scenario that is refused has an error");
  for (const io::Diagnostic& each : result.diagnostics) {
    if (each.severity != io::Severity::error) continue;
    found.require(each.line > 0 && !each.what.empty(), "an error has its place and says what is wrong", each.message());
    ++found.counts["refused: " + each.what];
  }
}

/// The energies of a diverged run may be NaN.
bool same_number(double one, double other) { return one == other || (std::isnan(one) && std::isnan(other)); }

double kinetic_scale(const Trace& run, const io::Scenario& scenario) {
  const EnergyBalance& e = run.energy;
  double mass = 0;
  for (const BodySpec& body : scenario.model.bodies()) mass += body.mass;
  return e.largest_kinetic + std::fabs(e.dissipated) + std::fabs(e.work) + std::fabs(e.lost_in_impacts) + std::fabs(e.released) +
         mass * norm(scenario.model.gravity()) + std::fabs(e.final - e.initial) + 1e-9 * std::fabs(e.initial) +
         1e-6;  // residues of closing loops move drives
}

class Checker {
 public:
  Checker(const io::Scenario& scenario, Choices& choose, Findings& found, bool continued = true)
      : scenario_(scenario), choose_(choose), found_(found), continued_(continued) {}

  void check() {
    run();
    if (!whole_.refused.empty()) return found_.require(false, "a scenario that was read can begin", whole_.refused);
    if (whole_.cut) {  // too stiff for its method: compared as far as it ran
      ++found_.counts["cut short"];
      scenario_.until = whole_.time;
      whole_ = traced_run(scenario_, {.until = scenario_.until, .most_steps = 2 * most_steps});
    }
    count();
    check_status();
    check_again();
    check_certificates();
    check_topology();
    if (continued_) check_restarts(), check_documents();
    check_checkpoints();
    check_conversion();
    check_energy();
    check_stepped();
  }

  /// Without those that need files again or other methods; of at most `steps` steps.
  void check_part(long steps) {
    most_ = steps;
    run();
    if (!whole_.refused.empty()) return found_.require(false, "a scenario that was read can begin", whole_.refused);
    if (whole_.cut) scenario_.until = whole_.time, whole_ = traced_run(scenario_, {.until = scenario_.until});
    count();
    check_status();
    check_again();
    check_certificates();
    check_topology();
    check_checkpoints();
    check_stepped();
  }

 private:
  void run() {
    InstantLaws laws(scenario_, found_);
    const std::size_t before = found_.broken.size();
    RunPlan plan{.until = scenario_.until, .most_steps = most_};
    plan.at_rows = [&](const Simulation& simulation) { laws.look(simulation); };
    // Fixed steps may be too long for stiff friction.
    if (is_adaptive(scenario_.integration.method))
      plan.after_steps = [&](const Simulation& simulation) { laws.follow(simulation); };
    whole_ = traced_run(scenario_, plan);
    // Its last numbers are meaningless, or all of them, of which the balance warns: the steps are too long.
    if (whole_.status == Status::diverged || std::fabs(whole_.energy.error) > whole_.energy.largest_kinetic)
      found_.broken.resize(before);
  }
  void count() {
    Counts& counts = found_.counts;
    static const char* const statuses[] = {"ok", "diverged", "interrupted", "refused", "stalled"};
    ++counts[std::string("status: ") + statuses[static_cast<int>(whole_.status)]];
    std::map<std::string, std::string> triggers;
    for (const io::ScenarioEvent& event : scenario_.events)
      triggers[event.name] = event.condition        ? "when " + std::string(event.condition->what->key())
                             : !event.after.empty() ? "after"
                             : event.period > 0     ? "every"
                                                    : "at";
    double last = -1;
    for (const Event& event : whole_.certificates) {
      const auto trigger = triggers.find(event.name);
      ++counts["trigger: " + (trigger != triggers.end() ? trigger->second : event.name.substr(0, event.name.find(' ')))];
      for (const std::string& action : event.action_texts())
        ++counts["action: " + action.substr(0, action.find(' ')) +
                 (action.find(" skipped: ") != std::string::npos ? " skipped" : "")];
      if (event.time == last) ++counts["several events at one instant"];
      last = event.time;
    }
  }

  void check_status() {
    const bool good = whole_.status == Status::ok;
    found_.require(good == whole_.message.empty(), "a run that fails says why", whole_.message);
    found_.require(whole_.state.find("nan") == std::string::npos && whole_.state.find("inf") == std::string::npos,
                   "the last state is finite");
    if (good) found_.require(whole_.time == scenario_.until, "a run ends at its end");
  }

  void require_same_run(const Trace& other, const std::string& law) {
    require_same(whole_.refused + whole_.message, other.refused + other.message, law + ": message", found_);
    require_same(rendered(whole_.events), rendered(other.events), law + ": events", found_);
    require_same_document(whole_.state, other.state, law + ": state", found_);
    found_.require(whole_.rows == other.rows, law + ": rows");
    const EnergyBalance &one = whole_.energy, &two = other.energy;
    found_.require(
        same_number(one.error, two.error) && same_number(one.work, two.work) && same_number(one.dissipated, two.dissipated),
        law + ": energy");
  }

  void check_again() {
    require_same_run(traced_run(scenario_, {.until = scenario_.until, .most_steps = 2 * most_steps}), "the same run again");
  }

  // A run that is saved and continued, even several times, equals the uninterrupted run to the last bit.
  void check_checkpoints() {
    if (whole_.steps < 2) return;
    RunPlan plan{.until = scenario_.until, .most_steps = 2 * most_steps};
    for (int left = choose_.integer(1, 4); left > 0; --left)
      plan.saved_after.push_back(choose_.integer(1, static_cast<int>(whole_.steps) - 1));
    std::sort(plan.saved_after.begin(), plan.saved_after.end());
    plan.saved_after.erase(std::unique(plan.saved_after.begin(), plan.saved_after.end()), plan.saved_after.end());
    const Trace continued = traced_run(scenario_, plan);
    found_.counts["checkpoints"] += static_cast<long>(plan.saved_after.size());
    std::string at = "continued from checkpoints after steps";
    for (const long step : plan.saved_after) at += ' ' + std::to_string(step);
    found_.require(whole_.events == continued.events, at + ": events",
                   "\n" + difference(rendered(whole_.events), rendered(continued.events)));
    found_.require(whole_.state == continued.state, at + ": state", "\n" + difference(whole_.state, continued.state));
    found_.require(whole_.times == continued.times && whole_.rows == continued.rows, at + ": rows");
    found_.require(whole_.counts == continued.counts, at + ": counts", whole_.counts + "\n--- but\n" + continued.counts);
    found_.require(whole_.message == continued.message && whole_.status == continued.status, at + ": status");
  }

  std::vector<Vec3> applied_impulses(const Event& happened) const;
  void check_certificates();
  void check_topology();
  void check_restart(const Trace& first, const std::string& law);
  void check_early_refusal(const std::string& refusal, const std::string& at);
  void check_restarts();
  void check_documents();
  void check_conversion();
  void check_energy();
  void check_stepped();

  io::Scenario scenario_;
  Choices& choose_;
  Findings& found_;
  bool continued_;
  Trace whole_;
  long most_ = most_steps;
};

// The external linear impulse of an event's actions, according to the scenario's events with these actions: several if a wildcard
// matches a joint or body that another action names, too.
std::vector<Vec3> Checker::applied_impulses(const Event& happened) const {
  std::vector<Vec3> all;
  std::vector<std::string> done = happened.action_texts();
  for (std::string& text : done) text.erase(std::min(text.find(" skipped: "), text.size()));
  std::sort(done.begin(), done.end());
  for (const io::ScenarioEvent& event : scenario_.events) {
    if (event.name != happened.name) continue;
    std::vector<std::string> said;
    Vec3 sum{};
    for (const Action& action : event.actions) {
      said.push_back(action.text());
      if (const auto* impulse = dynamic_cast<const actions::Impulse*>(&*action)) sum += impulse->force;
    }
    std::sort(said.begin(), said.end());
    if (said == done) all.push_back(sum);  // an impulse is never skipped
  }
  if (all.empty()) all.emplace_back();
  return all;
}

// Checks the energy and momentum balance of each event, and that certificates of one instant are chained.
void Checker::check_certificates() {
  if (whole_.status == Status::diverged) return;  // the last events before divergence have meaningless numbers
  double mass = 0, lightest = HUGE_VAL;
  for (const BodySpec& body : scenario_.model.bodies()) {
    mass += body.mass;
    if (body.mass > 0) lightest = std::min(lightest, body.mass);
  }
  // A mechanism whose root becomes a light body loses as many digits as that body is lighter than the rest.
  const double digits = std::max(1e-11, 1e-13 * mass / lightest);
  const Event* last = nullptr;
  for (const Event& e : whole_.certificates) {
    const std::string where = e.name + " at " + std::to_string(e.time);
    const double size = std::fabs(e.before.kinetic) + std::fabs(e.before.potential) + std::fabs(e.after.kinetic) +
                        std::fabs(e.after.potential) + std::fabs(e.lost) + std::fabs(e.released) + std::fabs(e.work);
    const double rounding = digits * size + 1e-14 * mass;  // some 10 m²/s² that cancel
    found_.within(
        std::fabs(e.after.kinetic + e.after.potential - e.before.kinetic - e.before.potential + e.lost + e.released - e.work),
        rounding, "certificate: energy", where);
    found_.within(-e.lost, rounding, "certificate: no impact gains energy", where);
    const Vec3 ground{e.ground_impulse[0], e.ground_impulse[1], e.ground_impulse[2]};
    const double speed = std::sqrt(2 * std::max({e.before.kinetic, e.after.kinetic, 0.0}) * mass);
    const double standstill = 1e-14 * mass;  // the rounding of velocities of some m/s that cancel
    double share = HUGE_VAL;
    for (const Vec3& applied : applied_impulses(e))
      share = std::min(share, norm(e.after.linear - e.before.linear - ground - applied) /
                                  (1e-10 * (speed + norm(ground) + norm(applied)) + standstill));
    found_.within(share, 1, "certificate: linear momentum", where);
    if (last != nullptr && last->time == e.time) {
      found_.within(std::fabs(last->after.kinetic + last->after.potential - e.before.kinetic - e.before.potential), rounding,
                    "certificates of one instant follow one another: energy", where);
      // Contacts that end or are located again: what impacts left is removed.
      const bool contact =
          e.name == "lift" || e.name == "slip" || e.name == "stick" || e.name == "resume" || last->name == "resume";
      const double earlier = std::sqrt(2 * std::max(last->before.kinetic, 0.0) * mass);
      const double unsolved = 5e-14 * mass;  // of velocities of some m/s: what impacts of the instant leave
      found_.within(norm(last->after.linear - e.before.linear),
                    1e-11 * std::max(speed, earlier) + (contact ? slowest_slip * mass : 10 * unsolved),
                    "certificates of one instant follow one another: momentum", where);
    }
    last = &e;
  }
  double lost = 0, size = 1e-12;
  for (const Event& e : whole_.certificates) lost += e.lost, size += std::fabs(e.lost);
  if (whole_.energy.lost_in_steps == 0)
    found_.within(std::fabs(lost - whole_.energy.lost_in_impacts), 1e-9 * size + 1e-9 * whole_.energy.largest_kinetic,
                  "what events lost is lost in impacts");
}

// The topology records of the events, applied one after the other, lead from the start to the end of the run.
void Checker::check_topology() {
  std::map<std::string, std::string> joints = whole_.joints_before;
  std::vector<std::string> mechanisms = whole_.mechanisms_before;
  for (const Event& event : whole_.certificates) {
    for (const std::string& name : event.topology.gone)
      found_.require(joints.erase(name) == 1, "joints that go were there", event.name + ": " + name);
    for (const JointRecord& joint : event.topology.joints) joints[joint.name] = joint_text(joint);
    for (const TopologyRecord::Moved& moved : event.topology.moved)
      for (const auto& [first, count] : moved.bodies)
        for (int b = first; b < first + count; ++b) mechanisms[static_cast<std::size_t>(b)] = moved.mechanism;
  }
  found_.require(mechanisms == whole_.mechanisms_after, "the events' records lead to the mechanisms at the end");
  found_.require(joints.size() == whole_.joints_after.size(), "the events' records lead to the joints at the end: names");
  for (const auto& [name, text] : whole_.joints_after)
    found_.require(joints[name] == text, "the events' records lead to the joints at the end", difference(joints[name], text));
}

// A continued run is refused early only for reasons for which it would be refused later, possibly after its end, because all
// events are tried. This cannot be checked if the whole run does not come that far, because it fails or is refused for another
// reason.
void Checker::check_early_refusal(const std::string& refusal, const std::string& at) {
  ++found_.counts["restarts refused early"];
  const Trace longer = traced_run(scenario_, {.until = 3 * scenario_.until, .most_steps = 8 * most_steps});
  const auto reason = [](std::string text) {  // without location and the text after the reason
    text.erase(std::min(text.find("; "), text.size()));
    text.erase(std::min(text.find(", on line"), text.size()));
    text.erase(std::min(text.find(" (event"), text.size()));
    const std::size_t error = text.find("error: ");
    return error == std::string::npos ? text : text.substr(text.find(": ", error + 7) + 2);
  };
  if (longer.status == Status::refused && longer.message.find(reason(refusal)) != std::string::npos) return;
  if (longer.status != Status::ok)
    ++found_.counts["restarts refused early for what is never reached"];
  else
    found_.require(false, at + ": refused", refusal + "\n--- but the whole run: " + longer.message);
}

// A run that was stopped, and a run that continues from its state, together equal the uninterrupted run.
void Checker::check_restart(const Trace& first, const std::string& law) {
  const io::test::TemporaryFolder folder;
  const std::string file = folder / "state.json";
  io::write_text_file(file, first.state);
  const Trace second = traced_run(scenario_, {.state = file, .until = scenario_.until, .most_steps = 2 * most_steps});
  ++found_.counts["restarts"];
  const std::string at = law + " at " + std::to_string(first.time);
  if (!second.refused.empty()) return check_early_refusal(second.refused, at);
  std::vector<std::string> events = first.events;
  events.insert(events.end(), second.events.begin(), second.events.end());
  require_same(rendered(whole_.events), rendered(events), at + ": events", found_);
  require_same(whole_.message, second.message, at + ": message", found_);
  // Sums of work may differ by a rounding: steps are searched again for peaks of the loads of joints with strengths.
  const auto without_work = [](std::string text) {
    const std::size_t from = text.find("\"integration\"");
    if (from == std::string::npos) return text;
    for (const char* key : {"\"work\"", "\"step\""}) {  // the next step is chosen by the error of the work, too
      const std::size_t place = text.find(key, from);
      if (place != std::string::npos) text.erase(place, text.find('\n', place) - place);
    }
    return text;
  };
  require_same_document(without_work(whole_.state), without_work(second.state), at + ": state", found_);
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < whole_.rows.size(); ++i)
    if (whole_.times[i] > first.time) rows.push_back(whole_.rows[i]);
  std::vector<std::string> later;
  for (std::size_t i = 0; i < second.rows.size(); ++i)
    if (second.times[i] > first.time) later.push_back(second.rows[i]);
  require_same(rendered(rows), rendered(later), at + ": rows", found_);
  if (whole_.status == Status::diverged) return;
  const double scale = kinetic_scale(whole_, scenario_);
  found_.within(std::fabs(first.energy.dissipated + second.energy.dissipated - whole_.energy.dissipated), 1e-10 * scale,
                law + ": dissipated", at);
  found_.within(std::fabs(first.energy.work + second.energy.work - whole_.energy.work), 1e-10 * scale, law + ": work", at);
}

void Checker::check_restarts() {
  if (whole_.rows.size() > 2) {
    for (int left = 2; left > 0; --left) {
      const double stop = whole_.times[static_cast<std::size_t>(choose_.integer(1, static_cast<int>(whole_.times.size()) - 1))];
      if (scenario_.output_every > 0 && stop < whole_.time)  // otherwise rows also occur where conditions fired within a step
        check_restart(traced_run(scenario_, {.until = stop, .most_steps = 2 * most_steps}), "restart from a row");
    }
  }
  if (whole_.steps > 2) {
    const long steps = choose_.integer(1, static_cast<int>(whole_.steps) - 1);
    const Trace first = traced_run(scenario_, {.until = scenario_.until, .most_steps = steps});
    // If a table has a bend within a rounding error of a row, the continued run takes the two for one instant.
    const bool beside_a_row = std::any_of(whole_.times.begin(), whole_.times.end(), [&](double time) {
      return time != first.time && std::fabs(time - first.time) < 1e-14 * (1 + time);
    });
    if (!beside_a_row) check_restart(first, "restart after an interruption");
  }
}

void Checker::check_documents() {
  const io::test::TemporaryFolder folder;
  const std::string file = folder / "state.json";
  io::write_text_file(file, whole_.state);
  try {
    io::Session session(scenario_, cli::documents_of(file, scenario_.model));
    static_cast<void>(session.schedule());  // warnings about events that are already past
    const StepMemory memory = step_memory(session.simulation());
    require_same_document(whole_.state, io::state_json(session.simulation().world(), session.armed(), memory),
                          "a document read and written again", found_);
  } catch (const Error& error) {
    check_early_refusal(error.message(), "a document read again");
  }
}

void Checker::check_conversion() {
  std::string text;
  try {
    text = io::to_toml(scenario_, MOMENTREE_MESHES).text;
  } catch (const Error& error) {
    return found_.require(false, "a scenario can be converted", error.message());
  }
  const io::ReadResult again = read_text(text);
  if (!again.scenario) return found_.require(false, "a converted scenario can be read", io::rendered(again.diagnostics));
  require_same_run(traced_run(*again.scenario, {.until = scenario_.until, .most_steps = 2 * most_steps}), "converted");
}

// The balance closes to the accuracy of the method, and almost exactly with small steps.
void Checker::check_energy() {
  if (whole_.status != Status::ok) return;
  const double scale = kinetic_scale(whole_, scenario_);
  io::Scenario fine = scenario_;
  fine.integration.method = "dop853", fine.integration.rtol = 1e-10, fine.integration.atol = 1e-12;
  InstantLaws laws(fine, found_);
  const std::size_t before = found_.broken.size();
  RunPlan plan{.until = scenario_.until, .most_steps = most_steps};
  plan.after_steps = [&](const Simulation& simulation) { laws.follow(simulation); };
  const Trace exact = traced_run(fine, plan);
  if (exact.status == Status::diverged) found_.broken.resize(before);
  const double accuracy = exact.energy.lost_in_steps == 0 ? 1e-6 : 1e-2;  // contacts are stepped through with the given step
  if (exact.refused.empty() && (exact.status == Status::ok || exact.cut))
    found_.within(std::fabs(exact.energy.error), accuracy * kinetic_scale(exact, scenario_), "energy balance of an accurate run");
  double error = std::fabs(whole_.energy.error), largest = error, last = error;
  fine = scenario_;
  for (int refined = 0; error > 1e-6 * scale; ++refined) {
    ++found_.counts["energy refined " + std::to_string(refined)];
    // An event soon after another one ends a step, which finer steps do not change before they are as short.
    const bool same = refined > 0 && std::fabs(error - last) < 1e-2 * error;
    last = error;
    // Stiff dampers of light bodies need steps that are 1000 times shorter.
    if (refined >= (same ? 7 : 5)) {
      char text[120];
      std::snprintf(text, sizeof text, "%.3e, refined %.3e, scale %.3e", whole_.energy.error, error, scale);
      return found_.require(false, "the energy balance closes with the step", text);
    }
    fine.integration.step /= 4, fine.integration.rtol /= 100, fine.integration.atol /= 100;
    const Trace finer = traced_run(fine, {.until = scenario_.until, .most_steps = 64 * most_steps});
    if (finer.cut || finer.status != Status::ok) return;
    // Conditions that hold after every step fire as often as there are steps: the motion is a different one.
    if (finer.certificates.size() != whole_.certificates.size()) return;
    error = std::fabs(finer.energy.error);
    if (error < 0.5 * largest) return;  // with one step errors may cancel by chance
    largest = std::max(largest, error);
  }
}

// The laws of every instant with contacts that are stepped through.
void Checker::check_stepped() {
  if (!scenario_.model.has_contact() || steps_through_contacts(scenario_.integration.method)) return;
  io::Scenario stepped = scenario_;
  stepped.integration.method = "stepping";
  InstantLaws laws(stepped, found_);
  const std::size_t before = found_.broken.size();
  RunPlan plan{.until = scenario_.until, .most_steps = most_};
  plan.at_rows = [&](const Simulation& simulation) { laws.look(simulation); };
  const Trace run = traced_run(stepped, plan);
  // Its numbers are meaningless, or its steps are too long.
  if (run.status == Status::diverged || std::fabs(run.energy.error) > run.energy.largest_kinetic)
    return found_.broken.resize(before);
  found_.require(run.rows == traced_run(stepped, {.until = scenario_.until, .most_steps = most_}).rows,
                 "the same run again, stepped: rows");
  // Impulses also move bodies, to the order of a step; dampers of bodies that contacts hold work in steps against both.
  const EnergyBalance& e = run.energy;
  found_.within(-e.lost_in_impacts - e.dissipated, 1e-2 * kinetic_scale(run, scenario_) + std::fabs(e.error),
                "contacts that are stepped through gain no energy");
}

}  // namespace

void check_file(const std::string& path, long steps, Choices& choose, Findings& found) {
  ++found.counts["scenarios"];
  try {
    const io::ReadResult read = io::read_scenario(path);
    if (!read.scenario) return found.require(false, "a file can be read", io::rendered(read.diagnostics));
    Checker(*read.scenario, choose, found).check_part(steps);
  } catch (const Error& error) {
    found.require(false, "nothing is thrown", error.message());
  }
}

void check_scenario(const std::string& text, Choices& choose, Findings& found, bool continued) {
  ++found.counts["scenarios"];
  try {
    const io::ReadResult one = read_text(text), other = read_text(text);
    require_same(io::rendered(one.diagnostics), io::rendered(other.diagnostics), "reading it again", found);
    if (one.scenario) return Checker(*one.scenario, choose, found, continued).check();
    ++found.counts["refused when read"];
    check_refusal(one, found);
  } catch (const Error& error) {
    found.require(false, "nothing is thrown", error.message());
  }
}

}  // namespace momentree::fuzz
