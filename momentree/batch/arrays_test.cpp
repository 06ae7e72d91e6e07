// Worlds of a batch read and written as arrays, compared with single worlds.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/misuse.hpp>

using namespace momentree;

namespace {

using List = std::vector<double>;
constexpr Variables both[] = {Variables::momenta, Variables::velocities};

// A free body with a ball joint, a driven joint and a branch: 7 + 4 + 1 + 1 + 1 coordinates.
Model robot() {
  Model model({.gravity = {0, 0, -9.81}});
  const auto body = [&](const char* name, BodyId parent, const JointSpec& joint) {
    return model.add({.name = name,
                      .mass = 1.5,
                      .com = {0.1, 0.02, -0.03},
                      .inertia = {0.03, 0.04, 0.05, 0.001, 0, 0.0005},
                      .parent = parent,
                      .at = Pose{{0.3, 0.05, 0}, normalized(Quat{1, 0.1, 0.2, -0.3})},
                      .joint = joint});
  };
  const BodyId hull = body("hull", ground, Free{});
  const BodyId arm = body("arm", hull, Ball{.damping = 0.1});
  body("hand", arm, Revolute{.axis = y_axis, .drive = motion_drive(Signal::sine(0.3, 1, 0.4))});
  const BodyId leg = body("leg", hull, Revolute{.axis = {1, 0, 1}, .armature = 0.01});
  body("foot", leg, Prismatic{.axis = x_axis, .stiffness = 50});
  return model;
}
constexpr int nq = 14, nv = 12;

List some(int count, unsigned seed, double size = 1) {
  std::mt19937 engine(seed);
  List all(static_cast<std::size_t>(count));
  for (double& x : all) x = size * (static_cast<double>(engine()) / 2147483647.5 - 1);
  return all;
}
List some_coordinates(int rows, unsigned seed) {
  List all = some(rows * nq, seed);
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row)
    for (const std::size_t at : {row * nq + 3, row * nq + 7}) {
      const double length =
          std::sqrt(all[at] * all[at] + all[at + 1] * all[at + 1] + all[at + 2] * all[at + 2] + all[at + 3] * all[at + 3]);
      for (std::size_t i = 0; i < 4; ++i) all[at + i] /= length;
    }
  return all;
}

double difference(std::span<const double> a, std::span<const double> b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(a[i] - b[i]));
  return worst;
}

std::vector<int> all_of(const Batch& batch) {
  std::vector<int> worlds;
  for (int i = 0; i < batch.worlds(); ++i) worlds.push_back(i);
  return worlds;
}

// All worlds at random states and times.
void scatter(Batch& batch) {
  const std::vector<int> worlds = all_of(batch);
  const List q = some_coordinates(batch.worlds(), 1), v = some(batch.worlds() * nv, 2);
  List time = some(batch.worlds(), 3), p(v.size());
  for (double& t : time) t = std::fabs(t);
  batch.momenta_of(worlds, q.data(), v.data(), p.data(), time.data());
  batch.write(worlds, time.data(), q.data(), p.data());
}

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

}  // namespace

TEST_CASE("rows are the states of their worlds, in any order, for any number of threads and lanes") {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512})
    for (const Variables variables : both) {
      if (!batch::available(isa)) continue;
      List first;
      for (const int threads : {1, 3}) {
        Batch batch(robot(), 37, {.variables = variables, .threads = threads, .widest = isa});
        scatter(batch);
        const std::vector<int> worlds = {36, 3, 0, 3, 17, 16, 8, 35, 1};
        List time(9), q(9 * nq), p(9 * nv), v(9 * nv), again(9 * nv);
        batch.read(worlds, time.data(), q.data(), p.data(), v.data());
        for (std::size_t row = 0; row < 9; ++row) {
          const State state = batch.state(worlds[row]);
          Workspace<double> workspace(batch.tree(worlds[row]));
          forward_dynamics(batch.tree(worlds[row]), state, workspace);
          CHECK(time[row] == state.time());
          CHECK(std::equal(state.q().begin(), state.q().end(), q.begin() + static_cast<std::ptrdiff_t>(row * nq)));
          const bool momenta = variables == Variables::momenta;
          const List& y = momenta ? p : v;
          CHECK(std::equal(state.y().begin(), state.y().end(), y.begin() + static_cast<std::ptrdiff_t>(row * nv)));
          CHECK(difference({workspace.v.get(), nv}, {v.data() + row * nv, nv}) < 1e-12);
          CHECK(difference(momenta ? state.p() : Numbers(workspace.p.get(), nv), {p.data() + row * nv, nv}) < 1e-12);
        }
        batch.read(worlds, nullptr, nullptr, nullptr, again.data());
        CHECK(again == v);
        again = v;
        again.insert(again.end(), p.begin(), p.end());
        if (!first.empty()) CHECK(first == again);
        first = again;
      }
    }
}

TEST_CASE("momenta of velocities give these velocities back; motions are followed and locked joints rest") {
  for (const Variables variables : both) {
    Batch batch(robot(), 11, {.variables = variables, .threads = 2});
    for (int i = 0; i < 11; ++i) batch.apply(i, Lock{{3}});
    const std::vector<int> worlds = all_of(batch);
    const List q = some_coordinates(11, 5), v = some(11 * nv, 6), time(11, 0.75);
    List p(v.size()), now_q(q.size()), now_v(v.size()), now_time(11);
    batch.momenta_of(worlds, q.data(), v.data(), p.data(), time.data());
    batch.write(worlds, time.data(), q.data(), p.data());
    batch.read(worlds, now_time.data(), now_q.data(), nullptr, now_v.data());
    CHECK(now_time == time);
    const auto motion = Signal::sine(0.3, 1, 0.4);
    const Curve::Point at = prescribed_motion(batch.tree(0), 2).at(0.75);
    for (std::size_t row = 0; row < 11; ++row)
      for (std::size_t i = 0; i < nv; ++i) {
        const double expected = i == 9 ? at.rate : i == 10 ? 0 : v[row * nv + i];
        CHECK(std::fabs(now_v[row * nv + i] - expected) < 1e-12);
      }
    for (std::size_t row = 0; row < 11; ++row) {
      CHECK(now_q[row * nq + 11] == at.value);
      CHECK(p[row * nv + 10] == 0);
      CHECK(p[row * nv + 9] == at.rate);
    }
    CHECK(std::fabs(motion.value(0.75) - at.value) < 1e-15);
    // Without times: at those of the worlds, which are now 0.75 s.
    List same(p.size());
    batch.momenta_of(worlds, q.data(), v.data(), same.data());
    CHECK(same == p);
  }
}

TEST_CASE("worlds take momenta or velocities, whatever they hold") {
  for (const Variables variables : both) {
    Batch one(robot(), 11, {.variables = variables, .threads = 2}), other(robot(), 11, {.variables = variables});
    for (Batch* batch : {&one, &other})
      for (int i = 0; i < 11; ++i) batch->apply(i, Lock{{3}});
    const std::vector<int> worlds = all_of(one), twice = {4, 2, 4};
    const List q = some_coordinates(11, 5), v = some(11 * nv, 6), time(11, 0.75);
    List p(v.size()), of_one[2] = {p, p}, of_other[2] = {p, p}, now_q(q.size());
    one.momenta_of(worlds, q.data(), v.data(), p.data(), time.data());
    one.write(worlds, time.data(), q.data(), p.data(), Variables::momenta);
    other.write(worlds, time.data(), q.data(), v.data(), Variables::velocities);
    one.read(worlds, nullptr, now_q.data(), of_one[0].data(), of_one[1].data());
    other.read(worlds, nullptr, nullptr, of_other[0].data(), of_other[1].data());
    for (const int i : {0, 1}) CHECK(difference(of_one[i], of_other[i]) < 1e-12);
    for (std::size_t row = 0; row < 11; ++row) CHECK(of_other[1][row * nv + 10] == 0);  // locked
    // At the present coordinates; the last row of a world counts.
    for (const Variables given : both) {
      other.write(twice, nullptr, nullptr, v.data(), given);
      List now(3 * nv), again = now;
      other.read(twice, nullptr, nullptr, given == Variables::momenta ? now.data() : nullptr,
                 given == Variables::momenta ? nullptr : now.data());
      CHECK(std::equal(now.begin(), now.begin() + nv, now.begin() + 2 * nv));
      const double driven = now[9];  // follows its motion
      for (std::size_t i = 0; i < nv; ++i)
        for (const std::size_t row : {std::size_t{1}, std::size_t{2}})
          CHECK(std::fabs(now[row * nv + i] - (i == 9 ? driven : i == 10 ? 0 : v[row * nv + i])) < 1e-12);
    }
    // New coordinates alone: what the worlds hold stays.
    const State before = one.state(3);
    one.write(std::vector<int>{3}, nullptr, q.data(), nullptr);
    CHECK(difference(before.y(), one.state(3).y()) == 0);
  }
}

TEST_CASE("worlds that were written move as simulations at the same states") {
  for (const Variables variables : both) {
    Batch batch(robot(), 10, {.variables = variables, .threads = 2});
    scatter(batch);
    batch.write(all_of(batch), List(10, 0.5).data(), nullptr, nullptr);
    std::vector<Simulation> alone;
    for (int i = 0; i < 10; ++i) {
      const State state = batch.state(i);
      alone.emplace_back(robot(), Integration{.variables = variables});
      alone.back().set_state(state.time(), state.q(), state.y(), variables);
    }
    for (int k = 0; k < 100; ++k) batch.step(1e-3);
    for (int i = 0; i < 10; ++i) {
      auto& sim = alone[static_cast<std::size_t>(i)];
      REQUIRE(sim.run_until(0.6) == Status::ok);
      CHECK(difference(batch.state(i).q(), sim.world().state().q()) < 1e-10);
      CHECK(difference(batch.state(i).y(), sim.world().state().y()) < 1e-10);
    }
  }
}

TEST_CASE("groups are numbered by their first worlds, and arrays are of one group") {
  Batch batch(robot(), 9);
  for (const int i : {1, 4, 8}) batch.apply(i, Break{{4}});
  batch.apply(2, Lock{{3}});
  CHECK(batch.groups() == 3);
  std::vector<int> groups;
  for (int i = 0; i < 9; ++i) groups.push_back(batch.group(i));
  CHECK(groups == std::vector<int>{0, 1, 2, 0, 1, 0, 0, 0, 1});
  CHECK(batch.nq(0) == nq);
  CHECK(batch.nv(1) == nv + 5);
  batch.apply(0, Break{{4}});
  CHECK(batch.group(0) == 0);
  CHECK(batch.group(3) == 2);
  List q(3 * static_cast<std::size_t>(batch.nq(1))), v(3 * static_cast<std::size_t>(batch.nv(1)));
  const std::vector<int> broken = {8, 0, 4}, mixed = {8, 3};
  batch.read(broken, nullptr, q.data(), nullptr, v.data());
  CHECK(std::equal(q.begin(), q.begin() + batch.nq(1), batch.state(8).q().begin()));
  const std::string said = error_of([&] { batch.read(mixed, nullptr, q.data(), nullptr, nullptr); });
  CHECK(said.find("worlds 8 and 3 have different topologies") != std::string::npos);
  CHECK(error_of([&] { batch.write(mixed, nullptr, q.data(), nullptr); }).find("topologies") != std::string::npos);
  CHECK(error_of([&] { batch.set_efforts(mixed, q.data()); }).find("topologies") != std::string::npos);
  CHECK(error_of([&] { batch.momenta_of(mixed, q.data(), v.data(), v.data()); }).find("topologies") != std::string::npos);
  batch.read({}, nullptr, nullptr, nullptr, nullptr);  // nothing to do
}

TEST_CASE("invalid rows are refused, and then no world has changed") {
  Batch batch(robot(), 4);
  scatter(batch);
  const std::vector<int> worlds = {2, 0, 3};
  List time(3), q(3 * nq), p(3 * nv);
  batch.read(worlds, time.data(), q.data(), p.data(), nullptr);
  const double bad = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](List all, std::size_t i, double x) {
    all[i] = x;
    return all;
  };
  const auto refused = [&](const List& t, const List& new_q, const List& new_p, const char* what) {
    List shifted = new_q;
    shifted[0] += 1;  // in a row before the bad one
    const std::string said = error_of([&] { batch.write(worlds, t.data(), shifted.data(), new_p.data()); });
    INFO(said);
    CHECK(said.find(what) != std::string::npos);
    CHECK(batch.state(2).q()[0] == q[0]);
    CHECK(batch.time(2) == time[0]);
  };
  refused(with(time, 2, -1), q, p, "not negative");
  refused(time, with(q, nq + 12, bad), p, "number 12 of the coordinates is not a number");
  refused(time, with(q, nq + 12, bad), p, "joint 'leg' of world '0'");
  refused(time, with(q, 2 * nq + 7, 9), p, "quaternion");
  refused(time, q, with(p, 2 * nv, HUGE_VAL), "number 0 of the momenta is inf");
  CHECK(error_of([&] {
          batch.write(worlds, nullptr, nullptr, with(p, 2 * nv, HUGE_VAL).data(), Variables::velocities);
        }).find("number 0 of the velocities is inf") != std::string::npos);
  CHECK(difference(batch.state(2).p(), {p.data(), nv}) == 0);
  CHECK(error_of([&] { batch.set_efforts(worlds, with(p, 1, bad).data()); }).find("efforts") != std::string::npos);
  const char* const no_world = "the batch has this world";
  const std::vector<int> none = {0, 4};
  test::check_stopped("a world that is not there", no_world, [&] { batch.read(none, time.data(), nullptr, nullptr, nullptr); });
}

TEST_CASE("efforts of all joints are those set one by one, and stay with their joints") {
  Batch together(robot(), 7, {.threads = 2}), single(robot(), 7);
  for (Batch* each : {&together, &single}) {
    scatter(*each);
    for (int i = 0; i < 7; ++i) each->apply(i, Lock{{4}});
  }
  const std::vector<int> worlds = {6, 1, 3};
  List efforts = some(3 * nv, 8, 5);
  efforts[0] = 0;
  together.set_efforts({worlds.data(), 2}, some(2 * nv, 9).data());  // replaced by the next call
  together.set_efforts(worlds, efforts.data());
  for (std::size_t row = 0; row < 3; ++row) {
    const Tree& tree = single.tree(worlds[row]);
    for (const int b : tree.order())
      for (int i = 0; i < info(tree.kind(b)).nv; ++i)
        single.set_effort(worlds[row], tree.inboard_joint({b}), i,
                          efforts[row * nv + static_cast<std::size_t>(tree.first_p(b) + i)]);
  }
  const auto equal = [&] {
    for (int i = 0; i < 7; ++i) CHECK(difference(together.state(i).p(), single.state(i).p()) == 0);
  };
  for (int k = 0; k < 10; ++k) together.step(1e-3), single.step(1e-3);
  equal();
  const State before = together.state(6);
  for (Batch* each : {&together, &single})
    for (int i = 0; i < 7; ++i) each->apply(i, Unlock{{4}});
  for (int k = 0; k < 10; ++k) together.step(1e-3), single.step(1e-3);
  equal();
  CHECK(difference(together.state(6).p(), before.p()) > 1e-3);
}

TEST_CASE("motions of bodies in worlds of different topologies") {
  for (const Variables variables : both) {
    Batch batch(robot(), 8, {.variables = variables, .threads = 3});
    scatter(batch);
    batch.apply(2, Break{{3}});
    batch.apply(5, Break{{3}});
    batch.apply(5, Remove{{3}});
    const std::vector<int> worlds = {7, 5, 2, 0};
    List rows(4 * 13);
    batch.motions(worlds, {3}, rows.data());
    for (std::size_t row = 0; row < 4; ++row) {
      const double* const at = rows.data() + 13 * row;
      if (worlds[row] == 5) {
        CHECK(std::all_of(at, at + 13, [](double x) { return std::isnan(x); }));
        continue;
      }
      const Tree& tree = batch.tree(worlds[row]);
      const State state = batch.state(worlds[row]);
      Workspace<double> workspace(tree);
      locate_bodies(tree, state, workspace);
      const BodyMotion m = user_motion(tree, workspace.bodies[3], 3);
      const Quat& o = m.pose.rotation;
      const List expected = {m.pose.position.x, m.pose.position.y, m.pose.position.z, o.w,         o.x,         o.y,        o.z,
                             m.linear.x,        m.linear.y,        m.linear.z,        m.angular.x, m.angular.y, m.angular.z};
      CHECK(difference(expected, {at, 13}) < 1e-12);
    }
    CHECK(error_of([&] { batch.motions(worlds, {5}, rows.data()); }).find("no") != std::string::npos);
  }
}

TEST_CASE("worlds in float can be read and written") {
  for (const Variables variables : both) {
    Batch batch(robot(), 20, {.precision = Precision::float32, .variables = variables, .threads = 2});
    scatter(batch);
    const std::vector<int> worlds = all_of(batch);
    List q(20 * nq), p(20 * nv), v(20 * nv), same(20 * nv);
    for (int k = 0; k < 20; ++k) batch.step(1e-3);
    batch.read(worlds, nullptr, q.data(), p.data(), v.data());
    batch.momenta_of(worlds, q.data(), v.data(), same.data());
    CHECK(difference(same, p) < 1e-4);
    if (variables == Variables::momenta) CHECK(difference(same, p) > 0);
    batch.write(worlds, nullptr, q.data(), p.data());
    CHECK_FALSE(batch.diverged(0));
  }
}

TEST_CASE("writing a world that diverged lets it continue") {
  Batch batch(robot(), 3);
  List q(nq), p(nv), wild(nv, 1e13);
  const std::vector<int> one = {1};
  batch.read(one, nullptr, q.data(), p.data(), nullptr);
  batch.write(one, nullptr, nullptr, wild.data());
  for (int k = 0; k < 3; ++k) batch.step(1e-3);
  CHECK(batch.diverged(1));
  const double start = 0;
  batch.write(one, &start, q.data(), p.data());
  CHECK_FALSE(batch.diverged(1));
  batch.step(1e-3);
  CHECK(batch.time(1) == 1e-3);
  CHECK_FALSE(batch.diverged(1));
}
