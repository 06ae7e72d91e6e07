#include <cli/run_report.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/integrate/integrator.hpp>
#include <momentree/results/results.hpp>

namespace momentree::cli {

namespace {

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > most) text += format(", … (%zu)", names.size());
  return text;
}

// "1.2e-16 relative", if there is a reference size.
std::string relative(double change, double size) {
  if (change == 0) return "0";
  return size > 0 ? format("%.1e", change / size) : "—";
}

std::string clock_table(const Simulation& simulation, const Style& style) {
  const RunStatistics& s = simulation.statistics();
  const double after = s.total_seconds[1] - s.topology_seconds;
  const auto row = [](std::string name, double evaluations, long count, double total) {
    return std::vector<std::string>{std::move(name), duration_text(evaluations), format("%ld", count),
                                    count > 0 ? duration_text(evaluations / static_cast<double>(count)) : "",
                                    duration_text(total)};
  };
  Table table;
  table.row({"", "function evaluations", "number", "each", "total simulation"});
  if (s.changes > 0) {
    table.row(row("simulation before the change", s.evaluation_seconds[0], s.evaluations[0], s.total_seconds[0]));
    table.row({s.changes == 1 ? "topology change" : format("topology changes (%ld)", s.changes),
               duration_text(s.topology_seconds), format("%ld", s.changes),
               duration_text(s.topology_seconds / static_cast<double>(s.changes)), duration_text(s.topology_seconds)});
    table.row(row("simulation after it", s.evaluation_seconds[1], s.evaluations[1], after));
  }
  const double evaluations = s.evaluation_seconds[0] + s.evaluation_seconds[1];
  table.row(row("whole simulation", evaluations, s.evaluations[0] + s.evaluations[1], s.total_seconds[0] + s.total_seconds[1]));
  return style.heading("Processing times") + '\n' + table.text("  ");
}

void add_conserved(Table& table, const char* what, const char* unit, const Vec3& before, const Vec3& after) {
  const double size = std::max(norm(before), norm(after)), change = norm(after - before);
  table.row({what, format("%.9g %s", norm(before), unit), format("%.9g %s", norm(after), unit),
             change == 0 ? "0" : format("%.1e %s", change, unit), relative(change, size)});
}

bool at_contact(const Event& event) { return !event.contact.one.empty(); }

std::string bodies_text(const Event::Contact& contact) {
  if (!contact.cable.empty()) return "cable " + contact.cable;
  const auto with_article = [](const std::string& body) { return body == "ground" ? "the ground" : body; };
  return with_article(contact.one) + " and " + with_article(contact.other);
}

std::string event_heading(const Event& event, const Style& style) {
  return "  " + style.heading(format("%.9g s  %s", event.time, event.name.c_str())) + "  ";
}

// One line: there are many of these events, and their certificates are in events.jsonl.
std::string contact_text(const Event& event, const Style& style) {
  std::string text = event_heading(event, style) + bodies_text(event.contact);
  if (const double size = norm(event.contact.impulse); size > 0) text += format("  impulse %.4g N s", size);
  if (event.lost > 0) text += format("  lost %.4g J", event.lost);
  if (!event.reason.empty()) text += "  " + event.reason;
  return text + '\n';
}

std::string event_text(const Event& event, const Style& style) {
  if (at_contact(event)) return contact_text(event, style);
  std::string text = event_heading(event, style);
  for (std::size_t i = 0; i < event.actions.size(); ++i) text += (i > 0 ? "; " : "") + event.actions[i].text();
  text += event.reason;
  if (!event.stepped.empty()) text += (event.reason.empty() ? "" : ": ") + joined(event.stepped);
  if (!event.stepped.empty() || !event.reason.empty()) return text + '\n';  // contacts are computed otherwise: nothing changes
  if (event.duration_ns > 0) text += "  " + style.dim("in " + duration_text(event.duration_ns * 1e-9));
  if (event.mechanisms_before != event.mechanisms_after)
    text += "\n    mechanisms: " + joined(event.mechanisms_before) + "  →  " + joined(event.mechanisms_after);
  const Totals &a = event.before, &b = event.after;
  const double before = a.kinetic + a.potential, after = b.kinetic + b.potential;
  Table table;
  table.row({"", "before", "after", "difference", "relative"});
  table.row({"energy", format("%.9g J", before), format("%.9g J", after),
             after == before ? "0" : format("%.1e J", after - before),
             relative(std::fabs(after - before), std::max(std::fabs(before), a.kinetic))});
  add_conserved(table, "linear momentum", "N s", a.linear, b.linear);
  add_conserved(table, "angular momentum", "N m s", a.angular, b.angular);
  text += '\n' + table.text("    ");
  if (event.released != 0)
    text += format("    released with %s: %.9g J\n",
                   event.topology.broken_springs.empty() ? "the degree of freedom" : "what broke", event.released);
  return text;
}

std::string energy_text(const EnergyBalance& e, const Style& style) {
  Table table;
  const double scale = std::max({std::fabs(e.initial), std::fabs(e.final), e.largest_kinetic});
  const auto row = [&](const char* name, double joules) {  // values at the level of rounding errors are printed as zero
    table.row({name, format("%.9g J", std::fabs(joules) < 1e-15 * scale ? 0.0 : joules)});
  };
  row("at the start", e.initial);
  row("at the end", e.final);
  row("dissipated by damping and friction", e.dissipated);
  row("work of efforts", e.work);
  if (e.lost_in_impacts != 0) row("lost in impacts", e.lost_in_impacts);
  if (e.released != 0) row("released by topology changes", e.released);
  if (e.projection != 0) row("by closing loops and removing overlaps", e.projection);
  std::string text = style.heading("Energy balance") + '\n' + table.text("  ");
  text += format("  error of the integration: %.2e J", e.error);
  if (e.largest_kinetic > 1e-12 * scale)
    text += format(", %.1e of the largest kinetic energy (%.4g J)", std::fabs(e.error) / e.largest_kinetic, e.largest_kinetic);
  return text + '\n';
}

std::string missed_text(const MissedEvent& m) {
  std::string text = "  " + m.name + ": ";
  if (m.quantity.empty()) {
    if (!m.after.empty() && !std::isfinite(m.time)) return text + "comes after " + m.after + ", which did not happen\n";
    return text + format("is due at %.9g s\n", m.time);
  }
  const char* const side = m.exceeds ? "exceeds" : "below";
  text += m.quantity;
  for (std::size_t i = 0; i < m.of.size(); ++i) text += (i == 0 ? " of " : " and ") + m.of[i];
  if (std::isnan(m.nearest)) return text + format(" %s %.9g: there was nothing to measure\n", side, m.threshold);
  text += format(" %s %.9g: came to %.6g at %.6g s", side, m.threshold, m.nearest, m.nearest_time);
  if (m.lasts > 0 && m.held > 0) text += format(", held for %.4g s of %.4g s", m.held, m.lasts);
  return text + '\n';
}

}  // namespace

std::string report_text(const RunReport& report, const Simulation& simulation, const Style& style) {
  const World& world = simulation.world();
  const RunStatistics& s = simulation.statistics();
  const double wall = s.total_seconds[0] + s.total_seconds[1], simulated = simulation.time() - report.start;
  std::string text =
      style.heading(report.title) + ": " + count_text(world.model().size(), "body", "bodies") + ", " +
      count_text(report.dofs, "degree of freedom", "degrees of freedom") + ", " + report.integration.method +
      (is_adaptive(report.integration.method) ? format(", rtol %.3g, atol %.3g", report.integration.rtol, report.integration.atol)
                                              : format(" with steps of %s", duration_text(report.integration.step).c_str())) +
      '\n';
  text += format("%.9g s simulated in %s", simulated, duration_text(wall).c_str());
  if (wall > 0 && simulated > 0) text += format(", %.3g times real time", simulated / wall);
  text += format("; %ld steps, the slowest %s\n\n", s.steps, duration_text(s.worst_step_seconds).c_str());
  text += clock_table(simulation, style);

  const std::vector<Event>& events = simulation.events();
  if (!events.empty()) text += '\n' + style.heading("Events") + '\n';
  constexpr std::size_t most = 20;
  std::size_t shown[2] = {}, left_out = 0;  // of contacts, and others: many impacts do not hide what breaks
  for (const Event& event : events)
    if (++shown[at_contact(event) ? 0 : 1] <= most)
      text += event_text(event, style);
    else
      ++left_out;
  if (left_out > 0) text += format("  … and %zu more, in events.jsonl\n", left_out);
  const std::vector<MissedEvent> missed = io::missed_events(simulation);
  if (!missed.empty()) text += '\n' + style.heading("Events that did not happen") + '\n';
  for (std::size_t i = 0; i < std::min(missed.size(), most); ++i) text += missed_text(missed[i]);
  if (missed.size() > most) text += format("  … and %zu more, in summary.json\n", missed.size() - most);
  if (!simulation.result().reason.empty()) return text;  // diverged: the last energies are meaningless
  return text + '\n' + energy_text(simulation.energy(), style);
}

}  // namespace momentree::cli
