// The output of `momentree convert` reads back to the same world: every scenario and model of this repository, and random trees
// of all joint kinds with every parameter.
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/motion.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/scenario.hpp>
#include <tests/oracle/same_dynamics.hpp>

namespace momentree::oracle {
namespace {

namespace fs = std::filesystem;

io::Scenario read(const std::string& text) {
  const io::ReadResult result = io::read_scenario_text(text, "written.toml");
  CAPTURE(text.substr(0, 4000));
  CAPTURE(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return *result.scenario;
}

/// Names, geometry, masses and start: to the last bit.
void check_same_bits(const Model& a, const Model& b) {
  REQUIRE(a.size() == b.size());
  const auto same = [](const Pose& x, const Pose& y) {
    return norm(x.position - y.position) == 0 && x.rotation.w == y.rotation.w && x.rotation.x == y.rotation.x &&
           x.rotation.y == y.rotation.y && x.rotation.z == y.rotation.z;
  };
  CHECK(norm(a.gravity() - b.gravity()) == 0);
  for (int i = 0; i < a.size(); ++i) {
    const BodySpec &x = a[BodyId{i}], &y = b[BodyId{i}];
    CAPTURE(x.name);
    CHECK(x.name == y.name);
    CHECK(x.joint_name == y.joint_name);
    CHECK(x.parent == y.parent);
    REQUIRE(x.joint.kind == y.joint.kind);
    CHECK(x.mass == y.mass);
    CHECK(norm(x.com - y.com) == 0);
    const Sym3 &s = x.inertia, &t = y.inertia;
    CHECK((s.xx == t.xx && s.yy == t.yy && s.zz == t.zz && s.xy == t.xy && s.xz == t.xz && s.yz == t.yz));
    CHECK(same(x.at, y.at));
    CHECK(same(x.child_at, y.child_at));
    const KindInfo& kind = info(x.joint.kind);
    if (kind.axis) CHECK(norm(x.joint.axis - y.joint.axis) == 0);
    if (kind.axis2) CHECK(norm(x.joint.axis2 - y.joint.axis2) == 0);
    if (kind.pitch) CHECK(x.joint.pitch == y.joint.pitch);
    CHECK(x.q == y.q);
    CHECK(x.v == y.v);
    const JointParameters &p = x.joint.parameters, &r = y.joint.parameters;
    for (int k = 0; k < kind.nv; ++k) {
      CHECK(p.damping.of(k) == r.damping.of(k));
      CHECK(p.stiffness.of(k) == r.stiffness.of(k));
      CHECK(p.armature.of(k) == r.armature.of(k));
      CHECK(p.limits.lower_of(k) == r.limits.lower_of(k));
      CHECK(p.limits.upper_of(k) == r.limits.upper_of(k));
      CHECK(p.limits.restitution_of(k) == r.limits.restitution_of(k));
      CHECK(p.limits.stiffness.of(k) == r.limits.stiffness.of(k));
      CHECK(p.limits.damping.of(k) == r.limits.damping.of(k));
      CHECK(p.friction.coulomb.of(k) == r.friction.coulomb.of(k));
      if (p.friction.coulomb.of(k) > 0) CHECK(p.friction.speed.of(k) == r.friction.speed.of(k));
    }
    CHECK(p.limits.rest_speed == r.limits.rest_speed);
    CHECK(p.strength == r.strength);
    if (!p.rest.empty() && p.stiffness.any()) CHECK((p.rest == r.rest || (r.rest.empty() && p.rest == joint_zero(kind.kind))));
  }
}

void check_same_dynamics(const Model& a, const Model& b, std::uint64_t seed, int states) {
  Prng random(seed);
  for (int k = 0; k < states; ++k) CHECK(difference(a, b, random_state(a, random)) <= 1e-12);
}

void check_same_events(const io::Scenario& a, const io::Scenario& b) {
  REQUIRE(a.events.size() == b.events.size());
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    const io::ScenarioEvent &x = a.events[i], &y = b.events[i];
    CHECK(x.name == y.name);
    CHECK(x.named == y.named);
    CHECK(x.time == y.time);
    CHECK(x.period == y.period);
    CHECK(x.after == y.after);
    CHECK(x.delay == y.delay);
    REQUIRE(x.condition.has_value() == y.condition.has_value());
    if (x.condition) {
      CHECK(x.condition->what->key() == y.condition->what->key());
      CHECK(x.condition->what->joints() == y.condition->what->joints());
      CHECK(x.condition->what->bodies() == y.condition->what->bodies());
      CHECK(x.condition->threshold == y.condition->threshold);
      CHECK(x.condition->above == y.condition->above);
      CHECK(x.condition->width() == y.condition->width());
      CHECK(x.condition->duration == y.condition->duration);
      CHECK(x.condition->repeats == y.condition->repeats);
      CHECK(x.condition->exact == y.condition->exact);
    }
    REQUIRE(x.actions.size() == y.actions.size());
    for (std::size_t k = 0; k < x.actions.size(); ++k) CHECK(x.actions[k].text() == y.actions[k].text());
  }
  CHECK(a.until == b.until);
  CHECK(a.output_every == b.output_every);
  CHECK(a.title == b.title);
  CHECK(a.integration.method == b.integration.method);
  CHECK(a.integration.step == b.integration.step);
  CHECK(a.integration.rtol == b.integration.rtol);
  CHECK(a.integration.atol == b.integration.atol);
  CHECK(a.integration.max_step == b.integration.max_step);
  CHECK(a.integration.event_tolerance == b.integration.event_tolerance);
  REQUIRE(a.model.forces().size() == b.model.forces().size());
  for (std::size_t i = 0; i < a.model.forces().size(); ++i) CHECK(a.model.forces()[i] == b.model.forces()[i]);
}

void check_same_shapes(const io::Scenario& a, const io::Scenario& b) {
  const auto same = [](const io::Shape& x, const io::Shape& y) {
    CHECK(x.kind == y.kind);
    CHECK(x.primitive == y.primitive);
    CHECK(norm(x.scale - y.scale) == 0);
    CHECK(norm(x.at.position - y.at.position) <= 1e-15);
    CHECK(x.colour == y.colour);
  };
  REQUIRE(a.shapes.size() == b.shapes.size());
  for (std::size_t i = 0; i < a.shapes.size(); ++i) {
    std::vector<io::Shape> here, there = b.shapes[i].more;
    there.insert(there.begin(), b.shapes[i]);
    for (const io::Shape& each : a.shapes[i].more) here.push_back(each);
    here.insert(here.begin(), a.shapes[i]);
    std::erase_if(here, [](const io::Shape& s) { return s.kind == io::Shape::Kind::mesh; });  // left out
    if (here.empty()) here.emplace_back();
    REQUIRE(here.size() == there.size());
    for (std::size_t k = 0; k < here.size(); ++k) same(here[k], there[k]);
  }
}

std::vector<std::string> files(const std::string& folder, const std::set<std::string>& endings) {
  std::vector<std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(MOMENTREE_SOURCE_DIR "/" + folder))
    if (endings.contains(entry.path().extension().string()) && entry.path().parent_path().filename() != "sweeps")
      all.push_back(entry.path().string());
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

TEST_CASE("every scenario and model, as TOML and back") {
  int count = 0;
  for (const std::string& file : files("scenarios", {".toml", ".urdf", ".xml"})) {
    CAPTURE(file);
    const io::ReadResult read_first = io::read_scenario(file);
    REQUIRE(read_first.scenario);
    const io::Scenario& first = *read_first.scenario;
    const std::string text = io::to_toml(first, "/nowhere").text;
    const io::Scenario second = read(text);
    check_same_bits(first.model, second.model);
    check_same_events(first, second);
    check_same_shapes(first, second);
    check_same_dynamics(first.model, second.model, 100 + static_cast<std::uint64_t>(++count), 5);
    CHECK(io::to_toml(second, "/nowhere").text == text);
    // Every body written out, including chains and everything that the scenario abbreviates.
    const std::string bodies = io::to_toml(first.model, first.shapes);
    const io::Scenario third = read(bodies);
    check_same_bits(first.model, third.model);
    check_same_dynamics(first.model, third.model, 200 + static_cast<std::uint64_t>(count), 5);
    // Solids that were read from capsules and cylinders differ by rounding from those that they were written for.
    CHECK(io::to_toml(third.model, third.shapes, false) == io::to_toml(first.model, first.shapes, false));
  }
  CHECK(count >= 25);
}

TEST_CASE("3,000 random trees, as TOML and back") {
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    RandomTreeOptions options;
    options.max_bodies = seed % 50 == 0 ? 200 : 12;
    options.drives = true;
    const Model model = random_tree(seed, options).model;
    const std::string text = io::to_toml(model);
    CAPTURE(seed);
    const Model again = read(text).model;
    check_same_bits(model, again);
    Prng random(seed);
    const double apart = difference(model, again, random_state(model, random));
    worst = std::max(worst, apart);
    CHECK(apart <= 1e-12);
    CHECK(io::to_toml(again) == text);
    if (seed % 10 == 0) CHECK(io::to_toml(read(text), "").text == text);
  }
  MESSAGE("worst difference of accelerations and momentum rates: " << worst);
}

}  // namespace momentree::oracle
