#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

// The results for valid models are compared with libsdformat too, in tests/cross.
constexpr double pi = std::numbers::pi;

std::string sdf(const std::string& inside, const std::string& version = "1.9") {
  return "<sdf version='" + version + "'>\n<model name='m'>\n" + inside + "\n</model>\n</sdf>";
}
std::string a_link(const std::string& name, const std::string& more = "") {
  return "<link name='" + name + "'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>" +
         more + "</link>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& more = "<axis><xyz>0 0 1</xyz></axis>") {
  return "<joint name='" + name + "' type='" + type + "'><parent>" + parent + "</parent><child>" + child + "</child>" + more +
         "</joint>\n";
}
Model read(const std::string& inside, const std::string& version = "1.9") { return model_of(sdf(inside, version), "m.sdf"); }

Pose start_of(const Model& model, const std::string& body) {
  const World world(model);
  return world.motions()[static_cast<std::size_t>(model.body("m/" + body).index)].pose;
}
/// The axis of the joint that carries a body, at the start, in the world's axes.
Vec3 axis_of(const Model& model, const std::string& body) {
  const BodySpec& spec = model[model.body("m/" + body)];
  return rotation_matrix((start_of(model, body) * spec.child_at).rotation) * spec.joint.axis;
}
void check_near(const Vec3& a, const Vec3& b) { CHECK(norm(a - b) <= 1e-14 * (1 + norm(b))); }
void check_near(const Pose& a, const Pose& b) {
  check_near(a.position, b.position);
  const Quat d = conjugate(a.rotation) * b.rotation;
  CHECK(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) < 1e-14);
}

const Pose p1{{0.1, 0.2, 0.3}, from_rpy(0.4, 0.5, 0.6)}, p2{{-1, 2, 0.5}, from_rpy(-1, 0.3, 2)};
const std::string pose1 = "0.1 0.2 0.3 0.4 0.5 0.6", pose2 = "-1 2 0.5 -1 0.3 2";

}  // namespace

TEST_CASE("SDF: a link's mass, centre of mass and inertia, turned from its axes into the link's") {
  const Model model = read(
      "<link name='a'><inertial><pose>1 2 3 0 0 1.5707963267948966</pose><mass>2</mass><inertia><ixx>1</ixx><ixy>0.1</ixy>"
      "<ixz>0.2</ixz><iyy>2</iyy><iyz>0.3</iyz><izz>2.5</izz></inertia></inertial></link>");
  REQUIRE(model.size() == 1);
  const BodySpec& a = model[{0}];
  CHECK(a.name == "m/a");
  CHECK(a.mass == 2);
  check_near(a.com, {1, 2, 3});
  const Sym3 expected{2, 1, 2.5, -0.1, -0.3, 0.2};
  for (auto m : {&Sym3::xx, &Sym3::yy, &Sym3::zz, &Sym3::xy, &Sym3::xz, &Sym3::yz})
    CHECK(a.inertia.*m == doctest::Approx(expected.*m).epsilon(1e-15));
  CHECK(a.joint.kind == Kind::free);  // it is not attached to anything
}

TEST_CASE("SDF: every type of joint, with its parameters") {
  std::string text = a_link("base");
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g", "h", "i"}) text += a_link(name);
  const std::string dynamics =
      "<dynamics><damping>0.5</damping><friction>0.25</friction><spring_stiffness>3</spring_stiffness>"
      "<spring_reference>0.1</spring_reference></dynamics>";
  text += joint("ja", "revolute", "base", "a",
                "<axis><xyz>0 0 2</xyz><limit><lower>-1</lower><upper>inf</upper></limit>" + dynamics + "</axis>");
  text += joint("jb", "continuous", "a", "b", "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>");
  text += joint("jc", "prismatic", "b", "c", "<axis/>");
  text += joint("jd", "fixed", "c", "d", "");
  text += joint("je", "ball", "d", "e", "");
  text += joint("jf", "universal", "e", "f",
                "<axis><xyz>1 0 0</xyz>" + dynamics + "</axis><axis2><xyz>0 1 0</xyz><limit><upper>2</upper></limit></axis2>");
  text += joint("jg", "revolute2", "f", "g", "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>1 1 0</xyz></axis2>");
  text += joint("jh", "screw", "g", "h", "<axis><xyz>0 0 1</xyz></axis><screw_thread_pitch>0.25</screw_thread_pitch>");
  text += joint("ji", "screw", "h", "i", "<axis><xyz>0 0 1</xyz></axis><thread_pitch>-3.141592653589793</thread_pitch>");
  const ReadResult result = read_scenario_text(sdf(text), "m.sdf", {"mechanism.m.limits=true"});
  CAPTURE(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  const auto of = [&](const char* name) -> const JointSpec& { return model[model.joint(std::string("m/") + name)].joint; };
  CHECK(of("ja").kind == Kind::revolute);
  check_near(of("ja").axis, {0, 0, 1});
  CHECK(of("ja").parameters.damping == Values(0.5));
  CHECK(of("ja").parameters.stiffness == Values(3));
  CHECK(of("ja").parameters.rest == Values(0.1));
  CHECK(of("ja").parameters.friction.coulomb == Values(0.25));
  CHECK(of("ja").parameters.limits.lower == Values(-1));
  CHECK(std::isinf(of("ja").parameters.limits.upper_of(0)));
  CHECK(of("jb").kind == Kind::revolute);
  check_near(of("jb").axis, {0, 1, 0});
  CHECK(!of("jb").parameters.limits.any());
  CHECK(of("jc").kind == Kind::prismatic);
  check_near(of("jc").axis, {0, 0, 1});  // the format's default
  CHECK(of("jd").kind == Kind::weld);
  CHECK(of("je").kind == Kind::ball);
  CHECK(of("jf").kind == Kind::universal);
  CHECK(of("jf").parameters.damping == Values{0.5, 0});
  CHECK(of("jf").parameters.rest == Values{0.1, 0});
  CHECK(std::isinf(of("jf").parameters.limits.upper_of(0)));
  CHECK(of("jf").parameters.limits.upper_of(1) == 2);
  CHECK(of("jg").kind == Kind::universal);
  check_near(of("jg").axis2, {std::sqrt(0.5), std::sqrt(0.5), 0});
  CHECK(of("jh").kind == Kind::helical);
  CHECK(of("jh").pitch == 0.25);
  CHECK(of("ji").pitch == doctest::Approx(2).epsilon(1e-15));  // −π rad/m of a left-handed thread
}

TEST_CASE("SDF: one mechanism, placed in many ways") {
  // A rotated joint in the link that it carries; both links are independent in the model.
  const std::string axis = "<axis><xyz>0.6 0 0.8</xyz></axis>";
  const auto links = [](const std::string& of_a, const std::string& of_b) {
    return a_link("a", "<pose" + of_a + "</pose>") + a_link("b", "<pose" + of_b + "</pose>");
  };
  const std::string plain = ">" + pose1;
  const auto check = [&](const std::string& text, const std::string& version = "1.9", bool turned = true) {
    CAPTURE(text);
    const Model model = read(text, version);
    check_near(start_of(model, "a"), p1);
    check_near(start_of(model, "b"), p1 * p2);
    const Vec3 own{0.6, 0, 0.8};
    check_near(axis_of(model, "b"), turned ? rotation_matrix((p1 * p2 * p1).rotation) * own : own);
    const BodySpec& b = model[model.joint("m/j")];
    check_near(b.at, p2 * p1);
    check_near(b.child_at, p1);
  };
  const std::string of_joint = "<pose>" + pose1 + "</pose>" + axis;
  const Quat q = p2.rotation;
  std::string quaternion = "-1 2 0.5";
  for (const double c : {q.x, q.y, q.z, q.w}) {
    char text[40];
    std::snprintf(text, sizeof text, " %.17g", c);
    quaternion += text;
  }
  check(links(plain, " relative_to='a'>" + pose2) + joint("j", "revolute", "a", "b", of_joint));
  check(links(plain, " relative_to='a' rotation_format='quat_xyzw'>" + quaternion) + joint("j", "revolute", "a", "b", of_joint));
  check(joint("j", "revolute", "a", "b", of_joint) + links(" frame=''>" + pose1, " frame='a'>" + pose2), "1.6");
  check(links(plain, " relative_to='f'>") + "<frame name='f' attached_to='a'><pose>" + pose2 + "</pose></frame>" +
        joint("j", "revolute", "a", "b", of_joint));
  check(links(plain, " relative_to='a'>" + pose2) +
        "<frame name='f' attached_to='b'/><frame name='g' attached_to='a'><pose relative_to='__model__'>1 2 3 4 5 "
        "6</pose></frame>" +
        joint("j", "revolute", "g", "f", of_joint));
  check(links(plain, " relative_to='a'>" + pose2) + "<frame name='f' attached_to='b'><pose>" + pose1 + "</pose></frame>" +
        joint("j", "revolute", "a", "f", axis));
  check(links(plain, " relative_to='a'>" + pose2) +
            joint("j", "revolute", "a", "b",
                  "<pose>" + pose1 + "</pose><axis><xyz expressed_in='__model__'>0.6 0 0.8</xyz></axis>"),
        "1.9", false);
  check(
      links(plain, " frame='a'>" + pose2) +
          joint("j", "revolute", "a", "b",
                "<pose>" + pose1 + "</pose><axis><xyz>0.6 0 0.8</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>"),
      "1.5", false);
  check(links(plain, " frame='a'>" + pose2) + joint("j", "revolute", "a", "b", of_joint), "1.4", false);
  // The pose of the model, and that of one of its frames.
  const std::string moved = "<pose>0 0 3 0 0 1</pose>";
  const Model model = read(moved + links(plain, " relative_to='a'>" + pose2) + joint("j", "revolute", "a", "b", of_joint));
  const Pose at{{0, 0, 3}, from_rpy(0, 0, 1)};
  check_near(start_of(model, "b"), at * p1 * p2);
  std::string text = sdf(moved + links(plain, " relative_to='a'>" + pose2) + joint("j", "revolute", "a", "b", of_joint));
  text.replace(text.find("name='m'"), 8, "name='m' placement_frame='b'");
  const Model placed = model_of(text, "m.sdf");
  check_near(start_of(placed, "b"), at);
  check_near(start_of(placed, "a"), at * inverse(p2));
}

TEST_CASE("SDF: degrees, and poses that are relative to a joint") {
  const Model model = read(a_link("a") + a_link("b", "<pose relative_to='j'/>") +
                           joint("j", "revolute", "a", "b", "<pose relative_to='a' degrees='true'>1 0 0 0 0 90</pose><axis/>"));
  check_near(start_of(model, "b"), {{1, 0, 0}, from_rpy(0, 0, pi / 2)});
  check_near(model[model.joint("m/j")].child_at, Pose{});
}

TEST_CASE("SDF: nested models are named by '::', and their frames reached by it") {
  const std::string inner = "<model name='n'><pose>1 0 0 0 0 1.5707963267948966</pose>" +
                            a_link("a", "<pose>1 0 0 0 0 0</pose>") + a_link("b") + joint("j", "fixed", "a", "b", "") +
                            "</model>";
  const Model model = read(a_link("a") + inner + joint("k", "revolute", "a", "n::a") +
                           a_link("c", "<pose relative_to='n::a'>0 1 0 0 0 0</pose>") + joint("l", "fixed", "n", "c", ""));
  REQUIRE(model.size() == 4);
  check_near(start_of(model, "n::a").position, {1, 1, 0});
  check_near(start_of(model, "c").position, {0, 1, 0});
  CHECK(model[model.joint("m/n::j")].name == "m/n::b");
  CHECK(model[model.joint("m/k")].name == "m/n::a");
  CHECK(model[model[model.joint("m/l")].parent].name == "m/n::a");  // the canonical link of n
  CHECK(model[model.body("m/a")].joint.kind == Kind::free);
}

TEST_CASE("SDF: a world has gravity, floating models, static models, and joints to the ground") {
  const auto model = [](const std::string& name, const std::string& inside) {
    return "<model name='" + name + "'>" + inside + "</model>\n";
  };
  const std::string text =
      "<sdf version='1.10'><world name='w'><gravity>0 0 -1.6</gravity><frame name='f'><pose>0 0 5 0 0 0</pose></frame>" +
      model("one", "<pose relative_to='f'>1 0 0 0 0 0</pose>" + a_link("a")) +
      model("two",
            "<static>true</static><pose>0 3 0 0 0 0</pose>" + a_link("a") + a_link("b") + joint("j", "revolute", "a", "b")) +
      model("three", a_link("a") + joint("j", "revolute", "world", "a", "<pose>0 0 1 0 0 0</pose><axis/>")) +
      joint("hook", "ball", "two::a", "four::a", "") + model("four", a_link("a")) + "</world></sdf>";
  const ReadResult result = read_scenario_text(text, "m.sdf", {"mechanism.m.limits=false"});
  CAPTURE(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& all = result.scenario->model;
  CHECK(result.scenario->title == "w");
  CHECK(all.gravity() == Vec3{0, 0, -1.6});
  CHECK(all[all.body("m/one::a")].joint.kind == Kind::free);
  check_near(start_of(all, "one::a").position, {1, 0, 5});
  for (const char* name : {"m/two::a", "m/two::b"}) {
    CHECK(all[all.body(name)].joint.kind == Kind::weld);
    CHECK(all[all.body(name)].parent == ground);
    check_near(all[all.body(name)].at.position, {0, 3, 0});
  }
  CHECK(all[all.body("m/three::a")].joint.kind == Kind::revolute);
  CHECK(all[all.body("m/three::a")].at.position == Vec3{0, 0, 1});
  CHECK(all[all.joint("m/hook")].name == "m/four::a");
  CHECK(all[all[all.joint("m/hook")].parent].name == "m/two::a");
  CHECK(said(result, Severity::note).find("a joint of a static model is ignored") != std::string::npos);
  // `root` applies to floating bodies only.
  const auto held = read_scenario_text(text, "m.sdf", {"mechanism.m.root=fixed"});
  REQUIRE(held.scenario);
  CHECK(held.scenario->model[held.scenario->model.body("m/one::a")].joint.kind == Kind::weld);
  CHECK(held.scenario->model[held.scenario->model.joint("m/hook")].joint.kind == Kind::ball);
  // Gravity as written in older versions, and the default of the format.
  const auto gravity = [&](const std::string& inside) {
    return model_of("<sdf version='1.4'><world name='w'>" + inside + model("one", a_link("a")) + "</world></sdf>", "m.sdf")
        .gravity();
  };
  CHECK(gravity("<physics type='ode'><gravity>0 0 -2</gravity></physics>") == Vec3{0, 0, -2});
  CHECK(gravity("") == Vec3{0, 0, -9.8});
}

TEST_CASE("SDF: default values of the format") {
  const ReadResult result = read_scenario_text(sdf("<link name='a'/>"), "m.sdf");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model[{0}].mass == 1);
  CHECK(result.scenario->model[{0}].inertia.yy == 1);
  CHECK(said(result, Severity::warning) ==
        "m.sdf:3:1: warning: a link without <inertial>: the format's defaults are a mass of 1 kg and an inertia of 1 kg m²; give "
        "a light link small numbers");
}

TEST_CASE("SDF: visuals are kept, where their poses say") {
  const auto visual = [](const std::string& geometry, const std::string& more = "") {
    return "<visual name='v'>" + more + "<geometry>" + geometry + "</geometry></visual>";
  };
  const ReadResult result = read_scenario_text(
      sdf(a_link("a", visual("<box><size>1 2 3</size></box>",
                             "<pose>1 0 0 0 0 0</pose><material><diffuse>1 0 0 1</diffuse></material>") +
                          visual("<cylinder><radius>0.5</radius><length>2</length></cylinder>", "<pose relative_to='f'/>") +
                          visual("<capsule><radius>0.5</radius><length>2</length></capsule>") +
                          visual("<sphere><radius>2</radius></sphere>") + visual("<mesh><uri>model://m/x.dae</uri></mesh>") +
                          visual("<plane/>")) +
          "<frame name='f'><pose>0 0 7 0 0 0</pose></frame>"),
      "m.sdf");
  CAPTURE(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Shape& first = result.scenario->shapes[0];
  CHECK(first.primitive == contact::Primitive(contact::Box{{1, 2, 3}}));
  CHECK(first.at.position == Vec3{1, 0, 0});
  CHECK(first.colour == "#ff0000");
  REQUIRE(first.more.size() == 4);
  CHECK(first.more[0].as<contact::Cylinder>());
  CHECK(first.more[0].at.position == Vec3{0, 0, 7});
  CHECK(first.more[1].primitive == contact::Primitive(contact::Capsule{0.5, 2}));
  CHECK(first.more[2].primitive == contact::Primitive(contact::Sphere{2}));
  CHECK(first.more[3].mesh == "m/x.dae");
}

TEST_CASE("SDF: ignored elements are reported once, with their lines") {
  const ReadResult result = read_scenario_text(
      sdf(a_link("a", "<collision name='c'/><sensor/><gravity>0</gravity>") + a_link("b", "<collision/><colision/>") +
          joint("j", "fixed", "a", "b", "<physics/>") + "<plugin/>\n<unheard/><drake:x/>\n"),
      "m.sdf");
  CAPTURE(rendered(result.diagnostics));
  CHECK(said(result, Severity::note) ==
        "m.sdf:3:127: note: <sensor> is ignored; it belongs to another program\n"
        "m.sdf:5:64: note: <physics> is ignored; it belongs to another program\n"
        "m.sdf:6:1: note: <plugin> is ignored; it belongs to another program\n"
        "m.sdf:7:1: note: <unheard> in <model> is ignored\n"
        "m.sdf:7:11: note: <drake:x> in <model> is ignored; it belongs to another namespace");
  CHECK(said(result, Severity::warning) ==
        "m.sdf:3:145: warning: <gravity> of a link is ignored: gravity acts on every body\n"
        "m.sdf:4:118: warning: <colision> in <link> is ignored; did you mean <collision>?");
}

TEST_CASE("SDF: the iiwa moves as its URDF does") {
  const auto read_file = [](const std::string& ending) {
    const ReadResult result =
        read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/models/iiwa14/iiwa14_no_collision." + ending,
                      {"mechanism.iiwa14_no_collision.limits=true", "mechanism.iiwa14_no_collision.root=fixed"});
    CAPTURE(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return result.scenario->model;
  };
  const Model urdf = read_file("urdf"), sdf = read_file("sdf");
  const auto name = [](int k) { return "iiwa14_no_collision/iiwa_joint_" + std::to_string(k); };
  std::uint32_t seed = 1;
  const auto random = [&seed] { return static_cast<double>(seed = seed * 1664525u + 1013904223u) / 4294967296.0 * 2 - 1; };
  for (int sample = 0; sample < 100; ++sample) {
    double q[8], v[8];
    for (int k = 1; k <= 7; ++k) q[k] = 2 * random(), v[k] = 2 * random();
    const auto accelerations = [&](const Model& model) {
      Model moved({.gravity = model.gravity()});
      for (BodySpec spec : model.bodies()) {
        for (int k = 1; k <= 7; ++k)
          if (spec.joint_name == name(k)) spec.q = q[k], spec.v = v[k], spec.joint.parameters.damping = {};  // the SDF has none
        moved.add_unjudged(spec);
      }
      const World world(moved);
      std::vector<double> a;
      for (int k = 1; k <= 7; ++k) a.push_back(world.joint_forces(moved.joint(name(k))).a[0]);
      return a;
    };
    const auto one = accelerations(urdf), other = accelerations(sdf);
    double largest = 0;
    for (const double a : one) largest = std::max(largest, std::fabs(a));
    for (std::size_t k = 0; k < one.size(); ++k) CHECK(std::fabs(one[k] - other[k]) <= 1e-9 * largest);
  }
  for (int k = 1; k <= 7; ++k)
    CHECK(urdf[urdf.joint(name(k))].joint.parameters.limits == sdf[sdf.joint(name(k))].joint.parameters.limits);
}

TEST_CASE("SDF: Cassie's loops are cut at the balls of its rods; it assembles, falls and swings its legs") {
  const std::string file = MOMENTREE_SOURCE_DIR "/scenarios/models/cassie/cassie_v2.sdf";
  const auto read_cassie = [&](const char* root) {
    const ReadResult result =
        read_scenario(file, {"mechanism.cassie_v2.limits=false", "mechanism.cassie_v2.root=" + std::string(root)});
    REQUIRE_MESSAGE(result.scenario, rendered(result.diagnostics));
    return result.scenario->model;
  };
  const Model model = read_cassie("free");
  std::string loops;
  for (const LoopSpec& loop : model.loops()) {
    CHECK(loop.joint.kind == Kind::ball);
    loops += loop.name.substr(loop.name.find('/') + 1) + " " + model[loop.to].name.substr(10) + "\n";
  }
  CHECK(loops ==
        "left-pitch-rod-joint left-achilles-rod\nright-pitch-rod-joint right-achilles-rod\n"
        "right-plantar-foot-joint right-plantar-rod\nleft-plantar-foot-joint left-plantar-rod\n");

  Simulation falling(model, {.method = "dopri5"});
  const double height = falling.world().motions()[0].pose.position.z;
  REQUIRE(falling.run_until(1).status == Status::ok);
  CHECK(std::fabs(falling.world().motions()[0].pose.position.z - height + 0.5 * 9.81) < 1e-9);

  Simulation swinging(read_cassie("fixed"), {.method = "dopri5", .rtol = 1e-9, .atol = 1e-10});
  const RunResult run = swinging.run_until(1);
  REQUIRE_MESSAGE(run.status == Status::ok, run.reason);
  const World& world = swinging.world();
  CHECK(std::fabs(world.joint(world.model().joint("cassie_v2/left-pitch-op")).q[0]) > 0.1);
  CHECK(world.loop_status().residual < 1e-7);
}
