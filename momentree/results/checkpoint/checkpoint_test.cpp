#include <momentree/results/checkpoint/checkpoint.hpp>

#include <doctest/doctest.h>

#include <momentree/results/checkpoint/event_fields.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/checksum.hpp>

using namespace momentree;

namespace {

template <class T>
T there_and_back(const T& value) {
  io::ArchiveWriter writer;
  writer(value);
  T back{};
  io::ArchiveReader reader(writer.bytes, "damaged");
  reader(back);
  CHECK(reader.at_end());
  io::ArchiveWriter again;
  again(back);
  CHECK(again.bytes == writer.bytes);
  return back;
}

void schedule(Simulation& simulation) {
  JointParameters parameters{.damping = 0.25};
  parameters.drive = effort_drive({Signal::sine(0.1, 2, 0.5, -0.0)});
  simulation.at(0.01).then(break_joint("arm/wrist"));
  simulation.at(0.02).then(set_parameters("pendulum", parameters));
  simulation.when(speed_of("pendulum").exceeds(100)).then(lock("pendulum"));
}

io::Checkpoint checkpoint_after(double time) {
  Simulation simulation(io::test::two_mechanisms());
  schedule(simulation);
  REQUIRE(simulation.run_until(time) == Status::ok);
  return {{"1.2.3", "0123456789abcdef", "5", true}, 60, simulation.run_state(), {}};
}

}  // namespace

TEST_CASE("the checksum is CRC-64/XZ") {
  io::Checksum whole, parts;
  whole.add("123456789");
  CHECK(whole.value() == 0x995dc9bbdf1939fau);  // the check value of the catalogue of CRC algorithms
  parts.add("1234");
  io::Checksum continued(parts.value());
  continued.add("56789");
  CHECK(continued.value() == whole.value());
  const std::string text(1000, 'x');
  io::Checksum at_once, singly;
  at_once.add(text);
  for (const char c : text) singly.add({&c, 1});
  CHECK(at_once.value() == singly.value());
}

TEST_CASE("parameters of joints read back to the same bits") {
  JointParameters p{
      .damping = {0.1, 1e-300, -0.0}, .stiffness = 2, .rest = {0.5, 0.25}, .armature = 1e-9, .effort = {1, 2, 3, 4, 5, 6}};
  p.limits = {.lower = -1, .upper = {1, HUGE_VAL}, .restitution = 0.5, .rest_speed = 2e-3, .stiffness = 100, .damping = 3};
  p.friction = {.coulomb = {1, 2}, .speed = 0.01};
  p.strength = {.force = 12};
  auto drive = std::make_shared<JointDrive>();
  drive->effort = {Signal(3), Signal::ramp(0.1, 0.2), Signal::table({{0, 1}, {1, 0.1}}), Signal::table({{0.5, 0.75}})};
  drive->pd = {.kp = 10, .kd = {1, 2}, .target = {Signal::sine(1, 2, 3, 4)}, .target_speed = {Signal(0.1)}, .max_effort = 5};
  drive->motion = {Curve(Signal::table({{0, 1}, {1, 0.1}, {2, 0.7}}, Signal::Ends::free)),
                   Curve(Signal::ramp_from_here(-0.3).begun_at(0.123456789, 0.7)), Curve(Signal::ramp_from_here(0.3))};
  p.drive = drive;
  const JointParameters back = there_and_back(p);
  CHECK(back == p);
  CHECK(back.drive->motion[0].at(0.3).acceleration == p.drive->motion[0].at(0.3).acceleration);
  CHECK(there_and_back(JointParameters{}) == JointParameters{});
}

TEST_CASE("a checkpoint reads back to the same bytes, and the run continues from it to the last bit") {
  const io::Checkpoint saved = checkpoint_after(0.03);
  const std::string bytes = io::checkpoint_bytes(saved);
  const io::Checkpoint read = io::read_checkpoint(bytes, "checkpoint");
  CHECK(io::checkpoint_bytes(read) == bytes);
  CHECK(read.input == saved.input);

  Simulation whole(io::test::two_mechanisms()), continued(io::test::two_mechanisms());
  schedule(whole), schedule(continued);
  REQUIRE(whole.run_until(0.03) == Status::ok);
  REQUIRE(whole.run_until(0.06) == Status::ok);
  io::require_fit(continued, read, "checkpoint");
  io::continue_run(continued, read);
  REQUIRE(continued.run_until(0.06) == Status::ok);
  CHECK(continued.world().snapshot().engine.q == whole.world().snapshot().engine.q);
  CHECK(continued.world().snapshot().engine.y == whole.world().snapshot().engine.y);
  CHECK(continued.events().size() == 2);
}

TEST_CASE("a checkpoint of a world with loops reads back to the same bytes, and one that is damaged is refused") {
  Model model = io::test::two_mechanisms();
  LoopSpec clasp;
  clasp.name = "clasp", clasp.body = model.body("arm/hand"), clasp.joint.kind = Kind::ball;
  clasp.at = World(model).motions()[static_cast<std::size_t>(clasp.body.index)].pose;
  model.add_loop(clasp);
  Simulation simulation(model);
  simulation.at(0.01).then(attach("arm/hand", "arm/base", clasp.joint)).named("more");
  simulation.at(0.02).then(lock("more"));
  REQUIRE(simulation.run_until(0.03) == Status::ok);
  REQUIRE(simulation.world().loops().size() == 2);
  const io::Checkpoint saved{{"1.2.3", "0123456789abcdef", "5", true}, 60, simulation.run_state(), {}};
  const std::string bytes = io::checkpoint_bytes(saved);
  const io::Checkpoint read = io::read_checkpoint(bytes, "checkpoint");
  CHECK(io::checkpoint_bytes(read) == bytes);
  CHECK(read.run.balance.projection == simulation.energy().projection);
  io::require_fit(simulation, read, "checkpoint");
  const auto damaged = [&](auto change) {
    io::Checkpoint changed = saved;
    change(changed.run.world.engine);
    CHECK(io::test::error_of([&] { io::require_fit(simulation, changed, "checkpoint"); }).find("damaged") != std::string::npos);
  };
  damaged([](Snapshot& engine) { engine.topology.loops[0].body = 99; });
  damaged([](Snapshot& engine) { engine.topology.loops[0].to = engine.topology.loops[0].body; });
  damaged([](Snapshot& engine) { engine.topology.loops[0].number = -1; });
  damaged([](Snapshot& engine) { engine.topology.loops[1].number = engine.topology.loops[0].number; });
  damaged([](Snapshot& engine) { engine.topology.loops[1].held = {}; });
  damaged([](Snapshot& engine) { engine.turns.resize(3); });
}

TEST_CASE("a world to which bodies were added, and from which some were removed, continues to the last bit") {
  Simulation whole(io::test::two_mechanisms()), continued(io::test::two_mechanisms());
  whole.set_gravity({0, 1, -5});
  const BodyId first = whole.add({.name = "new/one",
                                  .mass = 1,
                                  .com = {0.1, 0, 0.2},
                                  .inertia = diagonal(0.1),
                                  .parent = whole.world().model().body("arm/hand"),
                                  .joint = Revolute{.axis = {0, 1, 0}, .damping = 0.1},
                                  .v = 0.3});
  REQUIRE(whole.run_until(0.01) == Status::ok);
  static_cast<void>(
      whole.add({.name = "new/ball", .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {0, 9, 9, 1, 0, 0, 0}},
                {contact::sphere(0.1), contact::box({0.1, 0.2, 0.3})}));
  whole.remove(first);
  whole.at(0.03).then(weld("new/ball", "arm/base")).named("joined");
  const io::Checkpoint saved{{}, 0, whole.run_state(), {}, scheduled(whole), {}};
  const io::Checkpoint read = io::read_checkpoint(io::checkpoint_bytes(saved), "checkpoint");
  CHECK(io::checkpoint_bytes(read) == io::checkpoint_bytes(saved));
  schedule(continued, read.scheduled);
  io::require_fit(continued, read, "checkpoint");
  io::continue_run(continued, read);
  for (Simulation* each : {&whole, &continued}) REQUIRE(each->run_until(0.06) == Status::ok);
  CHECK(continued.world().snapshot().engine.q == whole.world().snapshot().engine.q);
  CHECK(continued.world().snapshot().engine.y == whole.world().snapshot().engine.y);
  CHECK(continued.events().size() == 4);
  CHECK(continued.energy().error == whole.energy().error);
  CHECK(continued.world().model().colliders() == whole.world().model().colliders());
  const auto damaged = [&](auto change) {
    io::Checkpoint changed = saved;
    change(changed.run.world);
    changed.run.queue.entries.clear();
    const Simulation fresh(io::test::two_mechanisms());
    CHECK(io::test::error_of([&] { io::require_fit(fresh, changed, "checkpoint"); }).find("damaged") != std::string::npos);
  };
  damaged([](WorldSnapshot& world) { world.added[0].parent.index = 99; });
  damaged([](WorldSnapshot& world) { world.added[0].mass = -1; });
  damaged([](WorldSnapshot& world) { world.added_colliders[0].body.index = 99; });
  damaged([](WorldSnapshot& world) { world.engine.topology.changed.clear(); });
}

TEST_CASE("scheduled events read back to the same bytes, whatever they do and depend on; those of a program are refused") {
  EventQueue::Entry entry;
  entry.event.actions = {attach("a/b", "c/d", Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}, .damping = 0.1}, Pose{{1, 2, 3}}),
                         impulse("a/b", {1, 2, 3}, {4, 5, 6}, {7, 8, 9}), lock("a/b", {0, 2})};
  for (const std::string& key : action_keys()) entry.event.actions.emplace_back(make_action(key));
  const EventQueue::Entry back = there_and_back(entry);
  for (std::size_t i = 0; i < entry.event.actions.size(); ++i)
    CHECK(back.event.actions[i].text() == entry.event.actions[i].text());
  for (const std::string& key : quantity_keys()) {
    entry.condition = Condition(make_quantity(key), 0.25, true).repeated(0.5).lasting(2);
    CHECK(there_and_back(entry).condition->what->key() == key);
  }
  entry.condition = beginning_to_slip("a/b", "ground");
  CHECK(!there_and_back(entry).condition->what->has_threshold());
  entry.condition = measured([](const World& world) { return world.time(); }).exceeds(1);
  io::ArchiveWriter writer;
  CHECK(io::test::error_of([&] { writer(entry); }).find("part of a program") != std::string::npos);
}

TEST_CASE("a changed, truncated or lengthened checkpoint is refused") {
  const std::string bytes = io::checkpoint_bytes(checkpoint_after(0.03));
  const auto refusal = [](const std::string& text) {
    return io::test::error_of([&] { static_cast<void>(io::read_checkpoint(text, "run.partial/checkpoint")); });
  };
  CHECK(refusal(bytes).empty());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
    const std::string error = refusal(changed);
    CHECK_MESSAGE(error.find("run without --resume") != std::string::npos, i, error);
  }
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) CHECK(!refusal(bytes.substr(0, size)).empty());
  CHECK(refusal(bytes + '\0').find("incomplete") != std::string::npos);
  CHECK(refusal("").find("run.partial/checkpoint: error: this is not a checkpoint of momentree") == 0);
}

TEST_CASE("a checkpoint of another model or of other events is refused") {
  const io::Checkpoint saved = checkpoint_after(0.03);
  const auto refusal = [&](const Simulation& simulation, const io::Checkpoint& checkpoint) {
    return io::test::error_of([&] { io::require_fit(simulation, checkpoint, "checkpoint"); });
  };
  Simulation same(io::test::two_mechanisms()), eventless(io::test::two_mechanisms());
  schedule(same);
  CHECK(refusal(same, saved).empty());
  CHECK(refusal(eventless, saved).find("of a run with other events") != std::string::npos);
  Model model = io::test::two_mechanisms();
  model.add({.name = "more", .mass = 1, .com = {0, 0, -1}, .joint = Revolute{.axis = {1, 0, 0}}});
  CHECK(refusal(Simulation(model), saved).find("of another model") != std::string::npos);
  const auto damaged = [&](auto change) {
    io::Checkpoint changed = saved;
    change(changed.run);
    CHECK(refusal(same, changed).find("damaged") != std::string::npos);
  };
  damaged([](RunState& run) { run.world.engine.q.pop_back(); });
  damaged([](RunState& run) { run.world.engine.y[0] = NAN; });
  damaged([](RunState& run) { run.world.engine.topology.places[1].parent = 1; });
  damaged([](RunState& run) { run.world.engine.topology.places[0].parent = 2, run.world.engine.topology.places[2].parent = 0; });
  damaged([](RunState& run) { run.world.engine.topology.places[0].joint = run.world.engine.topology.places[1].joint; });
  damaged([](RunState& run) { run.world.engine.topology.changed.at(0).as.parameters = 1000; });
  damaged([](RunState& run) { run.world.joint_names = {{99, "x"}}; });
  damaged([](RunState& run) { run.world.active_limits = {{0, 6, 1}}; });
  damaged([](RunState& run) { run.proposal = -1; });
}
