// MJCF as MuJoCo reads it and computes it.
#include <memory>

#include <mujoco/mujoco.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/cross/random_state.hpp>

namespace momentree::peers {
namespace {

std::string name_of(std::string_view full) { return std::string(full.substr(full.find('/') + 1)); }

struct Engine {
  explicit Engine(const std::string& path) {
    char trouble[1000] = "";
    model.reset(mj_loadXML(path.c_str(), nullptr, trouble, sizeof trouble));
    REQUIRE_MESSAGE(model, trouble);
    // Neither contacts, stops nor dry friction: what follows from mass, springs, dampers and gravity.
    model->opt.disableflags |= mjDSBL_CONSTRAINT;
    data.reset(mj_makeData(model.get()));
  }
  int joint(std::string_view full) const {
    const int id = mj_name2id(model.get(), mjOBJ_JOINT, name_of(full).c_str());
    REQUIRE_MESSAGE(id >= 0, std::string(full));
    return id;
  }
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
};

// Its free joint moves in the world's axes, ours in those of the body: v = Rᵀ v', and the derivative of that.
void put(const BodySpec& body, Engine& engine) {
  if (info(body.joint.kind).nv == 0) return;
  const int id = engine.joint(body.joint_name);
  double* q = engine.data->qpos + engine.model->jnt_qposadr[id];
  double* v = engine.data->qvel + engine.model->jnt_dofadr[id];
  for (int i = 0; i < body.q.size(); ++i) q[i] = body.q[i];
  for (int i = 0; i < body.v.size(); ++i) v[i] = body.v[i];
  if (body.joint.kind != Kind::free) return;
  const Vec3 linear = rotation_matrix(Quat{q[3], q[4], q[5], q[6]}) * Vec3{v[0], v[1], v[2]};
  v[0] = linear.x, v[1] = linear.y, v[2] = linear.z;
}

std::vector<double> theirs_of(const BodySpec& body, const Engine& engine) {
  const int nv = info(body.joint.kind).nv;
  if (nv == 0) return {};
  const double* a = engine.data->qacc + engine.model->jnt_dofadr[engine.joint(body.joint_name)];
  std::vector<double> theirs(a, a + nv);
  if (body.joint.kind != Kind::free) return theirs;
  const Mat3 R = rotation_matrix(Quat{body.q[3], body.q[4], body.q[5], body.q[6]});
  const Vec3 turning = cross(Vec3{body.v[3], body.v[4], body.v[5]}, Vec3{body.v[0], body.v[1], body.v[2]});
  const Vec3 linear = transpose_times(R, Vec3{a[0], a[1], a[2]}) - turning;
  theirs[0] = linear.x, theirs[1] = linear.y, theirs[2] = linear.z;
  return theirs;
}

// Mass, centre of mass and inertia as MuJoCo has them. Its principal axes are found to 1.4e-6 rad (the cosine of a last turn to
// 1e-12), so that an inertia that is not along the body's axes agrees to that only; what follows is compared with its own.
void take_inertia(BodySpec& body, const Engine& engine) {
  const int id = mj_name2id(engine.model.get(), mjOBJ_BODY, name_of(body.name).c_str());
  if (id < 0) return;  // a carrier
  const double *m = engine.model->body_inertia + 3 * id, *q = engine.model->body_iquat + 4 * id,
               *c = engine.model->body_ipos + 3 * id;
  const Sym3 theirs = rotate(rotation_matrix(Quat{q[0], q[1], q[2], q[3]}), diagonal(m[0], m[1], m[2])), &ours = body.inertia;
  CHECK(body.mass == doctest::Approx(engine.model->body_mass[id]).epsilon(1e-12));
  CHECK(norm(body.com - Vec3{c[0], c[1], c[2]}) < 1e-12);
  for (auto e : {&Sym3::xx, &Sym3::yy, &Sym3::zz, &Sym3::xy, &Sym3::xz, &Sym3::yz})
    CHECK(std::fabs(ours.*e - theirs.*e) <= 3e-6 * (m[0] + m[1] + m[2]));
  body.inertia = theirs;
}

void compare(const std::string& path, std::uint64_t seed, bool own_inertias) {
  const io::ReadResult result =
      io::read_scenario(path, {"mechanism." + std::filesystem::path(path).stem().string() + ".collision=none"});
  CAPTURE(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  Engine engine(path);
  Model model({.gravity = result.scenario->model.gravity()});
  for (BodySpec body : result.scenario->model.bodies()) {
    body.joint.parameters.friction = {};
    if (!own_inertias) take_inertia(body, engine);
    model.add_unjudged(std::move(body));
  }
  CHECK(compile(model).nv() == engine.model->nv);
  for (int b = 0; b < model.size(); ++b) {
    const int id = mj_name2id(engine.model.get(), mjOBJ_BODY, name_of(model[{b}].name).c_str());
    if (id > 0) CHECK(model[{b}].mass == doctest::Approx(engine.model->body_mass[id]).epsilon(1e-12));
  }
  oracle::Prng random(seed);
  for (int sample = 0; sample < 100; ++sample) {
    const Model here = at_random_state(model, random);
    for (const BodySpec& body : here.bodies()) put(body, engine);
    mj_forward(engine.model.get(), engine.data.get());
    const World world(here);
    double largest = 0, worst = 0;
    for (int b = 0; b < here.size(); ++b) {
      const auto a = world.joint_forces({b}).a;
      const std::vector<double> theirs = theirs_of(here[{b}], engine);
      REQUIRE(theirs.size() == a.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, std::fabs(theirs[i]));
        worst = std::max(worst, std::fabs(a[i] - theirs[i]));
      }
    }
    CAPTURE(sample);
    REQUIRE(largest > 0);
    CHECK(worst <= bound * largest);
  }
}

}  // namespace

TEST_CASE("MuJoCo: accelerations of the humanoid at 100 random states") {
  compare(MOMENTREE_SOURCE_DIR "/scenarios/models/mjcf_humanoid/humanoid.xml", 1, true);
}

TEST_CASE("MuJoCo: every joint, every geom, orientations, classes and compiler settings, at 100 random states") {
  const io::test::TemporaryFolder folder;
  const std::string world = R"(
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base" pos="0.1 0.2 0.3" euler="10 20 30" childclass="thick">
      <freejoint name="float"/>
      <geom type="box" size="0.2 0.1 0.05" pos="0.05 0 0" euler="40 0 10"/>
      <body name="a" pos="0.3 0 0" axisangle="1 1 0 50">
        <joint name="a1" type="hinge" axis="1 2 3" pos="0.01 0.02 0.03" ref="20" stiffness="3" springref="-15" damping="0.3"/>
        <joint name="a2" type="slide" axis="0 1 1" pos="0.03 0 0" ref="0.1" stiffness="30" springref="0.2" armature="0.2"/>
        <joint name="a3" type="hinge" axis="0 0 1" class="stiff"/>
        <geom type="capsule" fromto="0 0 0 0.1 0.2 0.3" size="0.04" density="7000"/>
        <geom type="sphere" size="0.07" pos="0 0 0.2" mass="4"/>
        <body name="b" pos="0 0.2 0.2" xyaxes="0 1 0 -1 0.2 0.3">
          <joint name="b1" type="ball" pos="0.02 0 0.01" damping="0.1" stiffness="2"/>
          <geom type="ellipsoid" size="0.1 0.2 0.05" quat="0.5 0.5 -0.5 0.5"/>
          <geom type="cylinder" size="0.05 0.2" zaxis="1 1 1" class="light"/>
          <body name="c" pos="0.1 0.1 0.1">
            <geom type="box" fromto="0 0 0 0.2 0.1 0" size="0.03"/>
            <body name="d" pos="0.2 0 0">
              <joint name="d1" axis="0 1 0"/>
              <inertial pos="0.1 0 0.02" quat="0.9 0.1 0.3 0.2" mass="7" diaginertia="0.1 0.12 0.15"/>
              <geom type="sphere" size="1"/>
            </body>
          </body>
          <body name="e" pos="0 0 0.3">
            <joint name="e1" axis="1 0 0" frictionloss="0.1"/>
            <inertial pos="0.1 0.05 0" mass="5" fullinertia="0.2 0.3 0.4 0.01 -0.02 0.03"/>
          </body>
        </body>
      </body>
    </body>
    <body name="second" pos="1 0 0">
      <joint name="pin" axis="0 1 0"/>
      <geom type="capsule" size="0.05 0.3"/>
    </body>
  </worldbody>)";
  const std::string defaults = R"(
  <default>
    <joint damping="0.05"/>
    <default class="stiff"><joint stiffness="5" armature="0.02"/></default>
    <default class="thick"><geom density="15000"/><default class="light"><geom density="2000"/></default></default>
  </default>)";
  const auto with = [&](const std::string& compiler, const std::string& body) {
    const std::string path = folder / "m.xml";
    io::write_text_file(
        path, "<mujoco model=\"m\"><compiler " + compiler + "/><option gravity=\"0.5 -1 -9\"/>" + defaults + body + "</mujoco>");
    compare(path, 2, false);
  };
  with("", world);
  with("angle=\"radian\" eulerseq=\"ZYx\"", world);
  with("inertiafromgeom=\"true\" settotalmass=\"12\"",
       "<worldbody><body name='a'><joint name='j' axis='0 1 0'/><inertial pos='0 0 0' mass='9' diaginertia='1 1 1'/>"
       "<geom type='capsule' size='.1 .3' pos='.2 0 0' group='1'/><body name='b' pos='0 0 1'><joint name='k' type='ball'/><geom "
       "size='.2' pos='.1 0 0'/>"
       "</body></body></worldbody>");
  with("balanceinertia=\"true\"",
       "<worldbody><body name='a'><joint name='j' axis='0 1 0'/><inertial pos='0.1 0 0' mass='9' diaginertia='1 1 "
       "3'/></body></worldbody>");
  with("boundmass=\"0.5\" boundinertia=\"0.01\" inertiagrouprange=\"0 0\"",
       "<worldbody><body name='a'><joint name='j' axis='0 1 0'/><inertial pos='0.1 0 0' mass='0.1' diaginertia='1e-3 1e-3 1e-3'/>"
       "<body name='b'><joint name='k' axis='1 0 0'/><geom size='.2' pos='0 .1 0'/><geom size='.4' "
       "group='1'/></body></body></worldbody>");
}

}  // namespace momentree::peers
