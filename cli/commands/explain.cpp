#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/text.hpp>
#include <momentree/derive/step.hpp>
#include <momentree/dynamics/count.hpp>
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/tree/kernel_run.hpp>

namespace momentree::cli {

namespace {

std::string axis_text(const Vec3& a) {
  const char* names[] = {"x", "y", "z"};
  const double along[] = {a.x, a.y, a.z};
  for (int i = 0; i < 3; ++i)
    if (std::fabs(along[i]) == 1) return std::string(along[i] < 0 ? "−" : "") + names[i];
  return format("(%.3g, %.3g, %.3g)", a.x, a.y, a.z);
}

std::string mass_text(double kg) {
  if (kg == 0) return "no mass";
  return std::fabs(kg) < 1 ? format("%.4g g", kg * 1e3) : format("%.6g kg", kg);
}

std::string kind_text(const JointView& joint) {
  const KindInfo& kind = info(joint.kind);
  std::string text = kind.name;
  if (kind.axis) text += (kind.v_units[0] == 'm' ? " along " : " about ") + axis_text(joint.axis);
  if (kind.axis2) text += " and " + axis_text(joint.axis2);
  if (kind.pitch) text += format(", %.4g mm a turn", joint.pitch * 1e3);
  return text;
}

/// The tree as lines of text: one per body, or per run of equal links.
class Drawing {
 public:
  explicit Drawing(const World& world) : world_(world), tree_(world.tree()) {}

  std::string of(BodyId root) {
    lines_.clear();
    std::vector<Open> open{{root.index, "", true}};
    while (!open.empty()) {
      const Open top = open.back();
      open.pop_back();
      const int last = end_of_run(top.body);
      add_line(top, last);
      std::vector<int> children;
      for (int c = tree_.first_child(last); c >= 0; c = tree_.next_sibling(c)) children.push_back(c);
      std::string indent = top.indent;
      if (width(indent) < widest_indent) indent += top.last ? "   " : "│  ";
      for (std::size_t i = children.size(); i-- > 0;) open.push_back({children[i], indent, i + 1 == children.size()});
    }
    std::size_t names = 0;
    for (const Line& line : lines_) names = std::max(names, width(line.name));
    std::string text = "  ground\n";
    for (const Line& line : lines_) text += "  " + padded(line.name, static_cast<int>(names)) + "   " + line.what + '\n';
    return text;
  }

 private:
  struct Open {
    int body;
    std::string indent;
    bool last;
  };
  struct Line {
    std::string name, what;
  };
  static constexpr std::size_t widest_indent = 60;
  static constexpr int shortest_run = 5;

  const BodySpec& spec(int b) const { return world_.model()[{b}]; }

  bool only_child(int b) const { return tree_.first_child(tree_.parent(b)) == b && tree_.next_sibling(b) < 0; }

  bool alike(int a, int b) const {
    const BodySpec &s = spec(a), &t = spec(b);
    const JointView j = world_.joint({a}), k = world_.joint({b});
    return s.mass == t.mass && s.com == t.com && j.kind == k.kind && j.axis == k.axis && j.axis2 == k.axis2 &&
           j.pitch == k.pitch && j.at.position == k.at.position;
  }

  /// The last body of the run of links equal to `b` that begins with it; `b` if that run is short.
  int end_of_run(int b) const {
    int last = b, count = 1;
    for (int c = tree_.first_child(b); c >= 0 && only_child(c) && alike(b, c); c = tree_.first_child(c)) last = c, ++count;
    return count >= shortest_run ? last : b;
  }

  void add_line(const Open& open, int last) {
    const JointView joint = world_.joint({open.body});
    std::string name = open.indent + (open.last ? "└─ " : "├─ ") + spec(open.body).name;
    std::string what = kind_text(joint);
    if (last != open.body) {
      int count = 1;
      for (int c = open.body; c != last; c = tree_.first_child(c)) ++count;
      name += " … " + spec(last).name;
      what = format("%d × ", count) + what + ", " + mass_text(spec(open.body).mass) + " each";
    } else {
      if (joint.name != spec(open.body).name) what = "'" + std::string(joint.name) + "', " + what;
      what += ", " + mass_text(spec(open.body).mass);
    }
    lines_.push_back({std::move(name), std::move(what)});
  }

  const World& world_;
  const Tree& tree_;
  std::vector<Line> lines_;
};

std::string joints_by_kind(const World& world) {
  std::vector<long> count(all_kinds().size(), 0);
  for (int b = 0; b < world.model().size(); ++b) ++count[static_cast<std::size_t>(world.tree().joint(b).kind)];
  std::string text;
  for (const KindInfo& kind : all_kinds())
    if (const long n = count[static_cast<std::size_t>(kind.kind)]; n > 0)
      text += (text.empty() ? "" : ", ") + format("%ld %s", n, kind.name);
  return text;
}

/// Bodies of mechanisms that move in a plane, which have separate kernels.
int bodies_in_planes(const Tree& tree) {
  int bodies = 0;
  for (const KernelRun& run : tree.tables().runs)
    if (run.planar) bodies += run.end - run.begin;
  return bodies;
}

/// DoFs that are locked or have a prescribed motion.
int held_dofs(const World& world) {
  int held = 0;
  for (int b = 0; b < world.model().size(); ++b) {
    const JointView joint = world.joint({b});
    const JointParameters* const parameters = joint.parameters;
    const bool driven = parameters != nullptr && parameters->drive && parameters->drive->moves();
    for (int i = 0; i < info(joint.kind).nv; ++i) held += driven || (joint.locked >> i & 1u) != 0 ? 1 : 0;
  }
  return held;
}

/// The loop joints, one line each.
std::string loops_text(const World& world) {
  Table table(Table::Values::left);
  const auto name = [&world](BodyId body) { return body == ground ? std::string("ground") : world.model()[body].name; };
  for (const JointId loop : world.loops()) {
    const JointView joint = world.joint(loop);
    table.row({"'" + std::string(joint.name) + "'", kind_text(joint), name(joint.child) + " to " + name(joint.parent)});
  }
  return table.text("  ");
}

std::string couplings_text(const World& world) {
  std::string text;
  for (int c = 0; c < world.couplings(); ++c) {
    const CouplingView view = world.coupling({c});
    const Coupling& law = view.coupling;
    const auto [joint, follows] = coupling_names(world, {c});
    text += "  '" + joint + "' = " + format("%g", law.offset);
    if (law.leads()) text += format(" %+g", law.multiplier) + "·'" + follows + "'";
    for (std::size_t i = 0; i < law.higher.size(); ++i)
      if (law.higher[i] != 0) text += format(" %+g", law.higher[i]) + "·'" + follows + format("'^%zu", i + 2);
    text += view.ended ? ", ended\n" : "\n";
  }
  return text;
}

std::string totals_text(const World& world) {
  double mass = 0;
  for (const BodySpec& body : world.model().bodies()) mass += body.mass;
  Table table(Table::Values::left);
  const auto row = [&table](const char* name, const std::string& value) { table.row({name, value}); };
  row("mechanisms", format("%zu", world.mechanisms().size()));
  row("bodies", format("%d", world.model().size()));
  row("joints", joints_by_kind(world));
  row("degrees of freedom", format("%d", world.tree().nv()));
  if (world.springs() > 0) row("springs", format("%d", world.springs()));
  row("mass", mass_text(mass));
  if (world.tree().has_loops()) {
    const LoopStatus loops = world.loop_status();
    const std::string equations = format(", %d equations, %d independent", loops.rows, loops.rank);
    if (!world.loops().empty()) row("loops", count_text(static_cast<long>(world.loops().size()), "joint", "joints") + equations);
    if (world.couplings() > 0)
      row("exact couplings", format("%d", world.couplings()) + (world.loops().empty() ? equations : " of these equations"));
    row("mobility", format("%d", world.tree().nv() - held_dofs(world) - loops.rank));
  }
  const Vec3 g = world.model().gravity();
  row("gravity", format("%g %g %g m/s²", g.x, g.y, g.z));
  const Operations operations = count_operations(world.tree());
  row("one evaluation", format("%ld operations (%ld additions, %ld multiplications, ", operations.total(), operations.additions,
                               operations.multiplications) +
                            count_text(operations.divisions, "division", "divisions") + ") and " +
                            count_text(operations.sincos, "pair", "pairs") + " of sine and cosine" +
                            (world.tree().has_loops() ? ", of the tree without its equations" : ""));
  if (const int bodies = bodies_in_planes(world.tree()); bodies > 0) row("in a plane", count_text(bodies, "body", "bodies"));
  return table.text("  ");
}

}  // namespace

namespace {

std::string when_text(const io::ScenarioEvent& event) {
  if (event.condition)
    return "when " + std::string(event.condition->what->key()) +
           format(event.condition->above ? " exceeds %g" : " is below %g", event.condition->threshold);
  if (!event.after.empty()) return event.delay > 0 ? format("%g s after ", event.delay) + event.after : "after " + event.after;
  if (event.period > 0) return format("every %g s from %g s on", event.period, event.time);
  return format("at %g s", event.time);
}

}  // namespace

namespace {

std::string springs_text(const World& world, const Style& style) {
  if (world.springs() == 0) return "";
  std::string text = '\n' + style.heading("Springs") + '\n';
  const auto name = [&](const SpringEnd& end) { return world.model().body_name(end.body); };
  for (int s = 0; s < world.springs(); ++s) {
    const SpringView spring = world.spring({s});
    text +=
        "  " + std::string(spring.name) + ": from " + name(spring.from) + " to " + name(spring.to) +
        (spring.inextensible ? format(", a cable of %g m, ends %g m apart", spring.law.rest, spring.length)
                             : format(", %g N/m, %g m long, %g m at rest", spring.law.stiffness, spring.length, spring.law.rest));
    if (spring.law.tension_only) text += ", pulls only";
    if (std::isfinite(spring.law.strength)) text += format(", breaks at %g N", spring.law.strength);
    text += spring.broken ? ", broken\n" : "\n";
  }
  return text;
}

}  // namespace

namespace {

/// The steps of a world's bodies, each once.
std::string code_text(const World& world, const Style& style) {
  const auto table =
      detail::make_step_table(world.state().variables() == Variables::momenta ? detail::double_steps(Passes::stage_momenta)
                                                                              : detail::double_steps(Passes::stage_velocities));
  if (!table->follow(world.tree())) throw std::bad_alloc();
  std::vector<std::pair<const derive::Step*, std::string>> steps;  // with the bodies that have them
  std::string others;
  const auto add = [](std::string& names, const std::string& name) { names += (names.empty() ? "" : ", ") + name; };
  for (const int b : world.tree().order()) {
    const std::string& name = world.model()[BodyId{b}].name;
    const derive::Step* const step = table->step_of(b);
    if (step == nullptr) {
      add(others, name);
      continue;
    }
    const auto known = std::ranges::find(steps, step, &decltype(steps)::value_type::first);
    if (known == steps.end())
      steps.emplace_back(step, std::string(info(world.tree().joint(b).kind).name) + ": " + name);
    else
      add(known->second, name);
  }
  std::string text;
  for (const auto& [step, names] : steps) text += style.heading(names) + '\n' + step->listing() + '\n';
  if (!others.empty())
    text += style.heading("Without steps of their own (generic functions, welded, or planar)") + ": " + others + '\n';
  return text;
}

}  // namespace

int explain(const ExplainOptions& options) {
  const std::shared_ptr<const io::Scenario> scenario = load(options.scenario, options.overrides, notes_of(options.verbose));
  if (!scenario) return bad_input;
  const io::Session session(scenario);
  const World& world = session.simulation().world();
  const Style style = Style::of_output();
  if (options.code) {
    show(stdout, code_text(world, style));
    return done;
  }

  std::string text = style.heading(scenario->title.empty() ? scenario->name : scenario->title) + '\n' + totals_text(world);
  Drawing drawing(world);
  for (const Mechanism& mechanism : world.mechanisms()) {
    int dofs = 0;
    double mass = 0;
    for (const BodyId body : mechanism.bodies) {
      dofs += info(world.tree().joint(body.index).kind).nv;
      mass += world.model()[body].mass;
    }
    text += '\n' + style.heading(mechanism.name) + ": " + (mechanism.grounded ? "grounded, " : "free, ") +
            count_text(static_cast<long>(mechanism.bodies.size()), "body", "bodies") + ", " +
            count_text(dofs, "degree of freedom", "degrees of freedom") + ", " + mass_text(mass) + '\n' +
            drawing.of(mechanism.root);
  }
  text += springs_text(world, style);
  if (!world.loops().empty()) text += '\n' + style.heading("Loops") + '\n' + loops_text(world);
  if (world.couplings() > 0) text += '\n' + style.heading("Exact couplings") + '\n' + couplings_text(world);
  if (!scenario->events.empty()) text += '\n' + style.heading("Events") + '\n';
  for (const io::ScenarioEvent& event : scenario->events)
    for (const Action& action : event.actions) text += "  " + when_text(event) + ": " + action.text() + '\n';
  show(stdout, text);
  return done;
}

}  // namespace momentree::cli
