// Closed loops of model files, against the same mechanisms as scenarios or as trees.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

// A four-bar linkage: crank AB, coupler BC, rocker DC.
const std::string sdf_inertial =
    "<inertial><pose>0.2 0 0.3 0 0 "
    "0</pose><mass>2</mass><inertia><ixx>0.3</ixx><iyy>0.2</iyy><izz>0.25</izz></inertia></inertial>";
std::string sdf_link(const std::string& name, const std::string& pose) {
  return "<link name='" + name + "'><pose>" + pose + "</pose>" + sdf_inertial + "</link>\n";
}
std::string sdf_joint(const std::string& name, const std::string& parent, const std::string& child,
                      const std::string& more = "") {
  return "<joint name='" + name + "' type='revolute'><parent>" + parent + "</parent><child>" + child +
         "</child><axis><xyz>0 1 0</xyz>" + more + "</axis></joint>\n";
}
const std::string spring = "<dynamics><damping>0.3</damping><spring_stiffness>2</spring_stiffness></dynamics>";
std::string four_bar_sdf(const std::string& dynamics = spring) {
  std::string closing = sdf_joint("j3", "coupler", "rocker", dynamics);
  closing.insert(closing.find("<axis>"), "<pose>-0.2 0 0.9 0 0 0</pose>");
  return "<sdf version='1.9'><model name='m'>" + sdf_link("crank", "0 0 0 0 0 0") + sdf_link("coupler", "0.3 0 0.4 0 0 0") +
         sdf_link("rocker", "1.2 0 0 0 0 0") + sdf_joint("j1", "world", "crank") + sdf_joint("j2", "crank", "coupler") + closing +
         sdf_joint("j4", "world", "rocker") + "</model></sdf>";
}
std::string four_bar_mjcf(
    const std::string& equality = "<connect name='j3' body1='rocker' body2='coupler' anchor='-0.2 0 0.9'/>") {
  const std::string inertial = "<inertial pos='0.2 0 0.3' mass='2' diaginertia='0.3 0.2 0.25'/>";
  return "<mujoco model='m'><worldbody>\n<site name='ground' pos='1 0 0.9' euler='0 90 0'/><body name='crank'>" + inertial +
         "<joint name='j1' axis='0 1 0'/><body name='coupler' pos='0.3 0 0.4'>" + inertial +
         "<joint name='j2' axis='0 1 0'/><site name='C' pos='0.7 0 0.5'/></body></body>\n<body name='rocker' pos='1.2 0 0'>" +
         inertial +
         "<joint name='j4' axis='0 1 0'/><site name='C2' pos='-0.2 0 0.9' euler='0 90 0'/></body>\n</worldbody>\n<equality>" +
         equality + "</equality></mujoco>";
}
std::string four_bar_toml(const std::string& loop, const std::string& gravity = "-9.81") {
  const auto body = [](const std::string& name, const std::string& joint, const std::string& more) {
    return "[[mechanism.body]]\nname = \"" + name +
           "\"\nmass = 2\ncom = [0.2, 0, 0.3]\ninertia = [0.3, 0.2, 0.25]\njoint = { name = \"" + joint +
           "\", kind = \"revolute\", axis = [0, 1, 0]" + more + " }\n";
  };
  return "format = 1\nworld = { gravity = [0, 0, " + gravity + "] }\n[[mechanism]]\nname = \"m\"\nroots = 2\n" +
         body("crank", "j1", "") + body("coupler", "j2", ", parent = \"crank\", at = { xyz = [0.3, 0, 0.4] }") +
         body("rocker", "j4", ", at = { xyz = [1.2, 0, 0] }") +
         "[[loop]]\nname = \"m/j3\"\nbody = \"m/rocker\"\nto = \"m/coupler\"\nchild_at = { xyz = [-0.2, 0, 0.9] }\n"
         "at = { xyz = [0.7, 0, 0.5] }\n" +
         loop;
}
const std::string revolute = "kind = \"revolute\"\naxis = [0, 1, 0]\n";

/// With a start speed of a joint.
Model moving(const Model& model, const std::string& joint, double speed) {
  Model moved({.gravity = model.gravity()});
  for (BodySpec spec : model.bodies()) {
    if (spec.joint_name == joint) spec.v = {speed};
    moved.add_unjudged(spec);
  }
  for (const LoopSpec& loop : model.loops()) moved.add_loop(loop);
  return moved;
}
/// Accelerations of joints, and the reaction of one. `speed`: of j1, before the velocities obey the loops.
std::vector<double> values_of(const Model& model, const std::vector<std::string>& joints, const std::string& loop = "",
                              double speed = 3) {
  const World world(moving(model, "m/j1", speed), Variables::velocities);
  std::vector<double> all;
  for (const std::string& joint : joints) all.push_back(world.joint_forces(world.model().joint("m/" + joint)).a[0]);
  if (!loop.empty()) {
    const auto reaction = world.joint_forces(world.model().joint("m/" + loop)).reaction;
    for (const Vec3& part : {reaction.force, reaction.torque}) all.insert(all.end(), {part.x, part.y, part.z});
  }
  return all;
}
/// The speed of j1 that obeys the loops.
double speed_of(const Model& model) {
  const World world(moving(model, "m/j1", 3), Variables::velocities);
  return world.joint(world.model().joint("m/j1")).v[0];
}
void check_near(const std::vector<double>& one, const std::vector<double>& other, double bound = 1e-12) {
  double largest = 0;
  for (const double x : other) largest = std::max(largest, std::fabs(x));
  REQUIRE(one.size() == other.size());
  CHECK(largest > 1);
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(std::fabs(one[i] - other[i]) <= bound * largest);
}
const std::vector<std::string> hinges{"j1", "j2", "j4"};

void check_energy(const Model& model) {
  Simulation sim(moving(model, "m/j1", 3), {.method = "dop853", .rtol = 1e-11, .atol = 1e-12});
  const Totals start = sim.world().totals();
  const RunResult run = sim.run_until(1);
  REQUIRE_MESSAGE(run.status == Status::ok, run.reason);
  const Totals end = sim.world().totals();
  CHECK(std::fabs(end.kinetic - start.kinetic) > 0.1);
  CHECK(std::fabs(end.kinetic + end.potential - start.kinetic - start.potential) < 1e-8 * start.kinetic);
  CHECK(sim.world().loop_status().residual < 1e-12);
}

/// A scenario with that model.
class Folder {
 public:
  ReadResult read(const std::string& model, const std::string& more, const std::string& file = "m.sdf") const {
    write_text_file(folder_ / file.c_str(), model);
    write_text_file(folder_ / "s.toml", "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"" + file + "\"\n" + more);
    return read_scenario(folder_ / "s.toml");
  }
  std::string says(const std::string& model, const std::string& more, Severity severity = Severity::error) const {
    std::string text = said(read(model, more), severity);
    for (std::size_t at; (at = text.find(folder_ / "")) != std::string::npos;) text.erase(at, (folder_ / "").size());
    return text;
  }
  std::string path(const char* name) const { return folder_ / name; }

 private:
  test::TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("SDF: a four-bar linkage moves as the same scenario does") {
  const Model model = model_of(four_bar_sdf(), "m.sdf");
  REQUIRE(model.loops().size() == 1);
  const LoopSpec& loop = model.loops()[0];
  CHECK(loop.name == "m/j3");
  CHECK(model[loop.body].name == "m/rocker");
  CHECK(model[loop.to].name == "m/coupler");
  CHECK(loop.joint.kind == Kind::revolute);
  check_near(values_of(model, hinges, "j3"),
             values_of(model_of(four_bar_toml(revolute + "damping = 0.3\nstiffness = 2\n"), "m.toml"), hinges, "j3"));
  check_energy(model_of(four_bar_sdf(""), "m.sdf"));
}

TEST_CASE("SDF: a loop through the ground, placed by the mechanism's pose") {
  const Folder folder;
  std::string text = four_bar_sdf("");
  // The rocker hangs on the coupler, and the ground closes the loop: by a ball, which has fewer rows.
  const std::size_t last = text.find("<joint name='j4' type='revolute'");
  text.replace(last, std::string("<joint name='j4' type='revolute'").size(), "<joint name='j4' type='ball'");
  const ReadResult result = folder.read(text, "pose = { xyz = [1, 2, 3] }\n");
  REQUIRE_MESSAGE(result.scenario, rendered(result.diagnostics));
  const Model& model = result.scenario->model;
  REQUIRE(model.loops().size() == 1);
  CHECK(model.loops()[0].name == "m/j4");
  CHECK(model.loops()[0].to == ground);
  CHECK(norm(model.loops()[0].at.position - Vec3{2.2, 2, 3}) < 1e-15);
  // Another tree gives another closed start velocity.
  const Model same = model_of(four_bar_toml(revolute), "m.toml");
  const double speed = speed_of(model);
  check_near(values_of(model, {"j1", "j2"}), values_of(same, {"j1", "j2"}, "", 3 * speed / speed_of(same)));
}

TEST_CASE("SDF: joints that form a cycle without a root float, and close at their first link") {
  const std::string cycle = "<sdf version='1.9'><model name='m'>" + sdf_link("a", "0 0 0 0 0 0") + sdf_link("b", "1 0 0 0 0 0") +
                            sdf_link("c", "0 0 1 0 0 0") + sdf_joint("ab", "a", "b") + sdf_joint("bc", "b", "c") +
                            sdf_joint("ca", "c", "a") + "</model></sdf>";
  const Model model = model_of(cycle, "m.sdf");
  CHECK(model[{0}].name == "m/a");
  CHECK(model[{0}].joint.kind == Kind::free);
  REQUIRE(model.loops().size() == 1);
  CHECK(model.loops()[0].name == "m/ca");
  CHECK(model[model.loops()[0].body].name == "m/a");
}

TEST_CASE("MJCF: connect and weld between bodies, between sites and to the world") {
  const Model by_bodies = model_of(four_bar_mjcf(), "m.xml");
  REQUIRE(by_bodies.loops().size() == 1);
  CHECK(by_bodies.loops()[0].name == "m/j3");
  CHECK(by_bodies.loops()[0].joint.kind == Kind::ball);
  check_near(values_of(by_bodies, hinges, "j3"), values_of(model_of(four_bar_toml("kind = \"ball\"\n"), "m.toml"), hinges, "j3"));
  check_near(values_of(by_bodies, hinges), values_of(model_of(four_bar_toml(revolute), "m.toml"), hinges));
  check_energy(by_bodies);

  const Model by_sites = model_of(four_bar_mjcf("<connect site1='C2' site2='C'/>"), "m.xml");
  CHECK(by_sites.loops()[0].name == "m/loop1");
  CHECK(norm(by_sites.loops()[0].at.position - Vec3{0.7, 0, 0.5}) == 0);
  CHECK(norm(rotation_matrix(by_sites.loops()[0].child_at.rotation) * Vec3{1, 0, 0} - Vec3{0, 0, -1}) < 1e-15);
  check_near(values_of(by_sites, hinges), values_of(by_bodies, hinges));

  const Model to_world = model_of(four_bar_mjcf("<connect body1='rocker' anchor='-0.2 0 0.9'/>"), "m.xml");
  CHECK(to_world.loops()[0].to == ground);
  CHECK(norm(to_world.loops()[0].at.position - Vec3{1, 0, 0.9}) < 1e-15);
  const Model from_world = model_of(four_bar_mjcf("<weld site1='ground' site2='C2'/>"), "m.xml");
  CHECK(from_world[from_world.loops()[0].body].name == "m/rocker");
  CHECK(from_world.loops()[0].to == ground);
  CHECK(norm(from_world.loops()[0].at.position - Vec3{1, 0, 0.9}) == 0);
}

TEST_CASE("MJCF: a welded body moves as one that is part of the tree") {
  const std::string inertial = "<inertial pos='0.2 0 0.3' mass='2' diaginertia='0.3 0.2 0.25'/>";
  const auto arm = [&](const std::string& inner, const std::string& outer, const std::string& equality) {
    return model_of("<mujoco model='m'><worldbody><body name='arm' euler='10 20 30'>" + inertial +
                        "<joint name='j1' axis='0 1 0.5' ref='30'/>" + inner + "</body>" + outer + "</worldbody><equality>" +
                        equality + "</equality></mujoco>",
                    "m.xml");
  };
  // The tip is where the arm has it in the pose of the file.
  const Model tree = arm("<body name='tip' pos='0.5 0.1 0' euler='0 0 90'>" + inertial + "</body>", "", "");
  const World world(tree);
  const Pose tip = world.motions()[1].pose;
  char pose[400];
  std::snprintf(pose, sizeof pose, "pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'", tip.position.x, tip.position.y,
                tip.position.z, tip.rotation.w, tip.rotation.x, tip.rotation.y, tip.rotation.z);
  const std::string free = "<body name='tip' " + std::string(pose) + ">" + inertial + "<freejoint name='f'/></body>";
  for (const char* weld : {"<weld body1='arm' body2='tip'/>", "<weld body1='tip' body2='arm' anchor='1 2 3'/>",
                           "<weld body1='arm' body2='tip' relpose='0.5 0.1 0 0.70710678118654757 0 0 0.70710678118654757'/>",
                           "<weld body1='arm' body2='tip' anchor='1 0 0' relpose='0.5 1.1 0 1 0 0 1'/>"}) {
    CAPTURE(weld);
    const Model welded = arm("", free, weld);
    REQUIRE(welded.loops().size() == 1);
    CHECK(welded.loops()[0].joint.kind == Kind::weld);
    check_near(values_of(welded, {"j1"}), values_of(tree, {"j1"}, "", speed_of(welded)), 1e-11);
  }
}

TEST_CASE("MJCF: an inactive equality is left out, one of joints is a joint that follows") {
  const ReadResult result = read_scenario_text(
      four_bar_mjcf(
          "\n<connect body1='rocker' anchor='0 0 0' active='false'/>\n<joint joint1='j4' joint2='j1' polycoef='0.1 2'/>\n"
          "<joint joint1='j2'/>\n<joint joint1='j2' joint2='j1' polycoef='0 0 0.1'/>\n<tendon/>\n"
          "<weld body1='crank' body2='rocker' solref='0.01 1' torquescale='2'/>"),
      "m.xml", {"mechanism.m.mimic.stiffness=10"});
  REQUIRE_MESSAGE(result.scenario, rendered(result.diagnostics));
  CHECK(said(result, Severity::note) ==
        "m.xml:6:1: note: <connect> in <equality> is left out: it is not active\n"
        "m.xml:11:44: note: solref in <equality> is ignored; loops are closed exactly\n"
        "m.xml:11:65: note: torquescale in <equality> is ignored; loops are closed exactly");
  CHECK(said(result, Severity::warning)
            .find("m.xml:10:1: warning: <tendon> in <equality> is left out: connect, weld and joint are read") !=
        std::string::npos);
  REQUIRE(result.scenario->model.elements().size() == 1);
  const auto& spring = std::get<elements::SpringCoupling>(result.scenario->model.elements()[0]);
  CHECK(spring.multiplier == 2);
  CHECK(spring.offset == 0.1);
  CHECK(result.scenario->model.loops().size() == 1);
  CHECK(result.scenario->model.couplings().size() == 2);  // that no spring can replace
}

TEST_CASE("tables of a mechanism give parameters to joints that close loops") {
  const Folder folder;
  const ReadResult result = folder.read(
      four_bar_sdf(),
      "[mechanism.joint.j3]\ndamping = 0.7\n"
      "[mechanism.joint.\"*\"]\nstiffness = 5\narmature = 0.1\n"
      "[[event]]\nwhen = { reaction_force = \"m/j3\", exceeds = 50, undetermined = \"least_norm\" }\nbreak = \"m/j3\"\n");
  REQUIRE_MESSAGE(result.scenario, rendered(result.diagnostics));
  const Model& model = result.scenario->model;
  const JointParameters& p = model.loops()[0].joint.parameters;
  CHECK(p.damping[0] == 0.7);
  CHECK(p.stiffness[0] == 5);
  CHECK(p.armature[0] == 0.1);
  CHECK(model[{0}].joint.parameters.armature[0] == 0.1);
  CHECK(result.scenario->events.size() == 1);
  const ReadResult strong = folder.read(
      "<mujoco><worldbody><body name='a'><geom size='0.1'/><joint axis='1 0 0'/></body><body name='b' pos='0 0 1'>"
      "<geom size='0.1'/><freejoint name='f'/></body></worldbody><equality><weld name='glue' body1='b' body2='a'/>"
      "</equality></mujoco>",
      "[mechanism.joint.glue]\nstrength = { force = 100 }\n", "m.xml");
  REQUIRE_MESSAGE(strong.scenario, rendered(strong.diagnostics));
  CHECK(strong.scenario->model.loops()[0].joint.parameters.strength.force == 100);

  CHECK(folder.says(four_bar_sdf(), "[mechanism.joint.j3]\nangle = 1\n") ==
        "s.toml:6:9: error: angle: joint 'j3' closes a loop and has no start values: its position follows from the other joints; "
        "give start values to the joints of the tree");
  CHECK(
      folder.says(four_bar_sdf(), "state = { joints = { j3 = 1 } }\n") ==
      "s.toml:5:27: error: state: joint 'j3' closes a loop and has no start values: its position follows from the other joints; "
      "give start values to the joints of the tree");
  CHECK(folder.says(four_bar_sdf(), "[mechanism.joint.\"j3*\"]\ndamping = -1\n")
            .starts_with("s.toml:6:11: error: joint 'j3': damping: must not be negative"));
  CHECK(folder.says(four_bar_sdf(), "[[coupling]]\njoint = \"m/j3\"\nfollows = \"m/j1\"\nstiffness = 1\n") ==
        "s.toml:6:9: error: joint: joint 'm/j3' closes a loop, where it can't be coupled; let another joint of the loop be the "
        "one that closes it");
  const std::string limits = "<limit><lower>-1</lower><upper>1</upper></limit>";
  const ReadResult limited = folder.read(four_bar_sdf(limits), "limits = true\n");
  REQUIRE_MESSAGE(limited.scenario, rendered(limited.diagnostics));
  CHECK(limited.scenario->model.loops()[0].joint.parameters.limits.upper[0] == 1);
  CHECK(folder.says(four_bar_sdf(limits), "", Severity::warning).find("the limits of 1 joint are not used") != std::string::npos);
}

TEST_CASE("loops of model files are written as loops of a scenario") {
  for (const auto& [text, name] : {std::pair(four_bar_sdf(), "m.sdf"), {four_bar_mjcf(), "m.xml"}}) {
    CAPTURE(name);
    const ReadResult result = read_scenario_text(text, name);
    REQUIRE(result.scenario);
    const Converted written = to_toml(*result.scenario, "");
    const Model again = model_of(written.text, "again.toml");
    REQUIRE(again.loops().size() == 1);
    CHECK(again.loops()[0].name == "m/j3");
    CHECK(again.loops()[0].joint.parameters.damping == result.scenario->model.loops()[0].joint.parameters.damping);
    CHECK(values_of(again, hinges, "j3") == values_of(result.scenario->model, hinges, "j3"));
  }
}
