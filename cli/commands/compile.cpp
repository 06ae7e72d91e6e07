#include <cstdio>
#include <optional>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/dynamics/count.hpp>
#include <momentree/generate/comment.hpp>
#include <momentree/generate/loop_kernel.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

namespace {

const char* unit_of_q(char letter) { return letter == 'r' ? "rad" : letter == 'm' ? "m" : "quaternion"; }
const char* unit_of_p(char letter) { return letter == 'r' ? "N m s" : "N s"; }
const char* unit_of_u(char letter) { return letter == 'r' ? "rad/s" : "m/s"; }

std::string range(const char* array, int first, int count) {
  return count == 1 ? format("%s[%d]", array, first) : format("%s[%d] to %s[%d]", array, first, array, first + count - 1);
}

std::string units(const char* letters, const char* (*unit)(char)) {
  std::string all;
  for (const char* c = letters; *c != '\0'; ++c)
    if (c == letters || *c != c[-1]) all += (all.empty() ? "" : ", ") + std::string(unit(*c));
  return all;
}

/// The positions of the joints' values in q and in p or u, a line for each moving joint.
std::string packing(const World& world, Variables variables) {
  const bool momenta = variables == Variables::momenta;
  Table table(Table::Values::left);
  const Tree& tree = world.tree();
  for (int number = 0; number < tree.bodies(); ++number) {
    const int b = tree.carrier(number);
    if (b < 0) continue;
    const KindInfo& kind = info(tree.joint(b).kind);
    if (kind.nv == 0) continue;
    table.row({comment_text(world.joint_name({number})) + ", " + kind.name, range("q", tree.first_q(b), kind.nq),
               units(kind.q_units, unit_of_q), range(momenta ? "p" : "u", tree.first_p(b), kind.nv),
               units(kind.v_units, momenta ? unit_of_p : unit_of_u)});
  }
  return table.text("");
}

/// Throws Error if the model has forces that cannot be generated; the message lists all of them.
void require_plain_forces(const World& world, const std::string& path) {
  std::string all;
  for (const OtherForce& force : other_forces(world.tree())) {
    const BodyId body{force.body};
    const std::string name(force.on_body ? std::string_view(world.model()[body].name)
                                         : world.joint_name(world.tree().inboard_joint(body)));
    all += (all.empty() ? "" : "; ") + std::string(force.on_body ? "body '" : "joint '") + name + "' has " + force.what;
  }
  if (!all.empty())
    throw_error(
        {all + ": generated code cannot include that", path,
         "with --without-joint-forces the code is the recursion alone; add all joint forces and forces on bodies yourself"});
}

/// Throws Error if a file cannot contain these closed loops; the message lists all reasons.
void require_plain_loops(const World& world, bool without_joint_forces, const std::string& path) {
  std::string all;
  bool only_forces = true;
  for (const LoopObstacle& obstacle : loop_obstacles(world.tree(), without_joint_forces)) {
    const JointId joint = world.tree().loops()[static_cast<std::size_t>(obstacle.loop)].id();
    all +=
        (all.empty() ? "" : "; ") + std::string("loop joint '") + std::string(world.joint_name(joint)) + "' has " + obstacle.what;
    only_forces = only_forces && obstacle.forces;
  }
  if (all.empty()) return;
  throw_error({all + ": generated code cannot include that", path,
               only_forces
                   ? "with --without-joint-forces the code is without the forces of all joints; or let another joint of the "
                     "loop be the one that closes it"
                   : "let another joint of the loop be the one that closes it"});
}

/// The prescribed motions of loop joints, whose accelerations are behind tau.
std::string loop_motions(const World& world) {
  std::string all;
  int next = world.tree().nv();
  for (const Loop& loop : world.tree().loops())
    if (loop.driven())
      all += format("tau[%d]: acceleration of the motion of %s\n", next++, comment_text(world.joint_name(loop.id())).c_str());
  return all;
}

}  // namespace

int compile(const CompileOptions& options) {
  const std::shared_ptr<const io::Scenario> scenario = load(options.scenario, options.overrides, notes_of(options.verbose));
  if (!scenario) return bad_input;
  refuse_to_overwrite(options.out, *scenario);
  const io::Session session(scenario);
  const World& world = session.simulation().world();
  const Tree& tree = world.tree();
  if (tree.nv() == 0) throw_error({"nothing in it moves: there is no kernel to write", scenario->path, ""});
  if (tree.has_loops() && options.variables == Variables::momenta)
    throw_error({"it has closed loops or exact couplings, which generated code supports only in velocities", scenario->path,
                 "use --variables velocities"});
  if (tree.has_loops()) require_plain_loops(world, options.without_joint_forces, scenario->path);
  if (!options.without_joint_forces) require_plain_forces(world, scenario->path);
  if (scenario->model.has_contact())
    show(stderr,
         printable(scenario->path) + ": warning: contact and cables are not in generated code; bodies pass through each other\n");
  if (!options.name.empty() && options.name != identifier(options.name))
    throw_error(
        {"'" + options.name + "' is not a valid function name", "", "use letters, digits and _, beginning with a letter"});

  const bool momenta = options.variables == Variables::momenta, forces = !options.without_joint_forces;
  const ChosenRows chosen = tree.has_loops() ? chosen_loop_rows(tree, world.state()) : ChosenRows();
  const auto accelerations = [&](bool with_forces) {
    if (!tree.has_loops()) return velocity_expressions(tree, with_forces);
    KernelExpressions all = loop_expressions(tree, chosen.rows, LoopCode::file, with_forces);
    all.least_pivots = chosen.least_pivots;
    return all;
  };
  KernelExpressions kernel = momenta ? kernel_expressions(tree) : accelerations(false);
  const long recursion = kernel.operations().total();
  if (forces && momenta) add_plain_forces(tree, kernel);
  if (forces && !momenta) kernel = accelerations(true);
  SourceText text;
  text.name = options.name.empty() ? identifier(scenario->name) : options.name;
  const Vec3& g = tree.gravity();
  text.about = (scenario->title.empty() ? scenario->name : scenario->title) +
               format(": %s, %s, gravity %g %g %g m/s^2.\n", count_text(tree.bodies(), "body", "bodies").c_str(),
                      count_text(tree.nv(), "degree of freedom", "degrees of freedom").c_str(), g.x, g.y, g.z) +
               (forces ? format("Dampers, springs and constant efforts of its joints are in %s.\n", momenta ? "pdot" : "udot")
                       : format("Without joint forces: add those of dampers, springs and drives to %s yourself.\n",
                                momenta ? "pdot" : "tau")) +
               (tree.joints_with().motions.empty() ? ""
                : momenta                          ? "For a joint whose motion is prescribed, p is the rate and pdot is zero.\n"
                          : "For a joint whose motion is prescribed, tau and udot are the acceleration.\n") +
               packing(world, options.variables) + loop_motions(world) +
               (tree.has_loops() ? format("Closed loops: %zu independent equations of %d, as at the start of the scenario.\n"
                                          "q and u must close the loops: correct them after each step.\n",
                                          chosen.rows.size(), tree.loops().rows)
                                 : "");
  const std::string source = kernel_source(kernel, text);
  const bool to_output = options.out == "-";
  if (to_output)
    std::fputs(source.c_str(), stdout);
  else
    io::write_text_file(options.out, source);

  const long before = count_operations(tree).total();  // in momenta
  const double bodies = tree.bodies();
  const std::string report =
      momenta ? format("%s_rates: %ld operations, %.1f per body, where the kernels take %ld, %.1f per body\n", text.name.c_str(),
                       recursion, static_cast<double>(recursion) / bodies, before, static_cast<double>(before) / bodies)
              : format("%s_accelerations: %ld operations, %.1f per body\n", text.name.c_str(), recursion,
                       static_cast<double>(recursion) / bodies);
  show(to_output ? stderr : stdout, report);
  return done;
}

}  // namespace momentree::cli
