#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/simulate/analysis/equilibrium.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree::cli {

namespace {

std::string numbers(std::span<const double> values) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "" : " ") + format("%.9g", x);
  return text;
}

std::string vector_text(const Vec3& v) { return format("%.9g %.9g %.9g", v.x, v.y, v.z); }

std::string evaluation_text(const World& world, const Style& style) {
  const Totals totals = world.totals();
  Table sums;
  sums.row({"time", format("%.9g s", world.time())});
  sums.row({"kinetic energy", format("%.9g J", totals.kinetic)});
  sums.row({"potential energy", format("%.9g J", totals.potential)});
  sums.row({"linear momentum (N s)", vector_text(totals.linear)});
  sums.row({"angular momentum (N m s)", vector_text(totals.angular)});
  Table joints, reactions, bodies;
  joints.row({"joint", "kind", "q", "v", "p", "dp/dt", "a"});
  reactions.row({"joint", "on", "force", "torque"});
  bodies.row({"body", "linear", "angular"});
  const Model& model = world.model();
  if (const LoopStatus& loops = totals.loops; loops.rows > 0)
    sums.row({"loops", format("%d equations, %d independent, open by %.2g", loops.rows, loops.rank, loops.residual)});
  const auto show_joint = [&](JointId number) {
    const JointView joint = world.joint(number);
    const JointForces forces = world.joint_forces(number);
    joints.row({std::string(joint.name), info(joint.kind).name, numbers(joint.q), numbers(joint.v), numbers(joint.p),
                numbers(joint.pdot), numbers(forces.a)});
    reactions.row({std::string(joint.name), model[joint.child].name, vector_text(forces.reaction.force),
                   vector_text(forces.reaction.torque), forces.determined ? "" : "not determined"});
  };
  for (int b = 0; b < model.size(); ++b) {
    show_joint({b});
    const BodyAcceleration& a = world.accelerations()[static_cast<std::size_t>(b)];
    bodies.row({model[BodyId{b}].name, vector_text(a.linear), vector_text(a.angular)});
  }
  for (const JointId loop : world.loops()) show_joint(loop);
  std::string springs;
  if (world.springs() > 0) {
    Table table;
    table.row({"spring", "length", "rate", "tension"});
    for (int s = 0; s < world.springs(); ++s) {
      const SpringView spring = world.spring({s});
      table.row({std::string(spring.name), format("%.9g", spring.length), format("%.9g", spring.rate),
                 spring.broken ? "broken" : format("%.9g", spring.tension)});
    }
    springs = '\n' + style.heading("Springs") + " (m, m/s, N)\n" + table.text("  ");
  }
  std::string couplings;
  if (world.couplings() > 0) {
    Table table;
    table.row({"joint", "follows", "effort"});
    for (int c = 0; c < world.couplings(); ++c) {
      const CouplingView view = world.coupling({c});
      const auto [joint, follows] = coupling_names(world, {c});
      table.row({joint, follows, view.ended ? "ended" : format("%.9g", view.effort), view.determined ? "" : "not determined"});
    }
    couplings = '\n' + style.heading("Exact couplings") + " (N, N m; on the joint)\n" + table.text("  ");
  }
  std::string contacts;
  if (const std::vector<ContactPoint> points = world.contacts(); !points.empty()) {
    Table table;
    table.row({"body", "touches", "point", "force", "slip"});
    for (const ContactPoint& point : points)
      table.row({model.body_name(point.one), model.body_name(point.other), vector_text(point.point), vector_text(point.force),
                 vector_text(point.slip)});
    contacts = '\n' + style.heading("Contacts") + " (m, N on the body, m/s)\n" + table.text("  ");
  }
  return style.heading("World") + '\n' + sums.text("  ") + '\n' + style.heading("Joints") + " (m, rad, s, kg)\n" +
         joints.text("  ") + '\n' + style.heading("Reactions") + " (N, N m; about the body's origin, in its axes)\n" +
         reactions.text("  ") + '\n' + style.heading("Accelerations") +
         " (m/s², rad/s²; of the body's origin, in the world's axes)\n" + bodies.text("  ") + springs + couplings + contacts;
}

std::string modes_text(const World& world, const Equilibrium& rest, const Style& style) {
  const auto joint_of = [&](int dof) { return std::string(world.joint_name(joint_of_dof(world.tree(), dof))); };
  std::string held;
  for (const int dof : rest.resting) held += " " + joint_of(dof);
  for (const int s : rest.taut) held += " " + std::string(world.spring({s}).name);
  if (!held.empty())
    held = "\n" + style.heading("Held by stops and cables:") + held +
           "\n  These act once a run has begun: accelerations and reactions above are without them.\n";
  if (rest.modes.empty()) return held;
  Table table;
  table.row({"frequency", "moves most"});
  for (const Mode& mode : rest.modes) {
    const auto most =
        std::max_element(mode.shape.begin(), mode.shape.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
    table.row({mode.square < 0 ? "unstable" : format("%.9g Hz", mode.frequency()),
               joint_of(static_cast<int>(most - mode.shape.begin()))});
  }
  return held + '\n' + style.heading("Modes") + " (without damping)\n" + table.text("  ");
}

}  // namespace

int evaluate(const EvaluateOptions& options) {
  const std::shared_ptr<const io::Scenario> scenario = load(options.scenario, options.overrides, notes_of(options.verbose));
  if (!scenario) return bad_input;
  io::Session session(scenario, documents_of(options.state, scenario->model));
  if (const std::optional<Overlap> worst = overlap(session.simulation()); worst && worst->depth > left_by_steps)
    throw_error({worst->text() + " in this state", options.state.empty() ? options.scenario : options.state,
                 "move one of them, or use the scenario for which the state was written"});
  const World& world = session.simulation().world();
  std::optional<Equilibrium> rest;
  if (options.equilibrium) {
    rest = equilibrium(world);
    const std::vector<double> still(world.state().y().size());
    session.simulation().set_state(world.time(), rest->q, still, Variables::velocities);
  }
  StepMemory memory = step_memory(session.simulation());
  if (options.state.empty() && scenario->state_files.empty()) memory.next_step = memory.work = 0;  // no step was made
  if (options.json)
    std::fputs(io::state_json(world, session.armed(), memory).c_str(), stdout);
  else
    show(stdout, evaluation_text(world, Style::of_output()) + (rest ? modes_text(world, *rest, Style::of_output()) : ""));
  return done;
}

}  // namespace momentree::cli
