// Worlds of a batch as arrays, a row per world.
#include <cmath>
#include <limits>
#include <numeric>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch_impl.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/simulate/assembly.hpp>

namespace momentree {

namespace {

std::size_t place(std::size_t row, int width) { return row * static_cast<std::size_t>(width); }
std::span<const double> row_of(const double* all, std::size_t row, int width) {
  return {all + place(row, width), static_cast<std::size_t>(width)};
}

void check_time(double time) {
  if (!(time >= 0) || !std::isfinite(time))
    throw_error({"the time of a world can't be " + std::to_string(time) + " s", "", "give finite times that are not negative"});
}

}  // namespace

Group& Batch::Impl::common(std::span<const int> worlds) const {
  MT_REQUIRE(!worlds.empty(), "at least one world");
  Group* const group = seat(worlds[0]).group;
  for (const int world : worlds)
    if (seat(world).group != group)
      throw_error({"worlds " + std::to_string(worlds[0]) + " and " + std::to_string(world) + " have different topologies", "",
                   "take the worlds of one group at a time: see Batch::group()"});
  return *group;
}

Group& Batch::Impl::common_rows(std::span<const int> worlds) {
  Group& group = common(worlds);
  call.rows.resize(worlds.size());
  std::iota(call.rows.begin(), call.rows.end(), 0);
  const auto slot_of = [&](int row) { return seats[static_cast<std::size_t>(worlds[static_cast<std::size_t>(row)])].slot; };
  const auto before = [&](int a, int b) { return slot_of(a) < slot_of(b); };
  if (!std::is_sorted(call.rows.begin(), call.rows.end(), before)) std::sort(call.rows.begin(), call.rows.end(), before);
  return group;
}

JointNamer Batch::Impl::namer(int world) const {
  return [this, world](int joint) {
    return (joint < basis.model.size() ? basis.model[JointId{joint}].joint_name : "#" + std::to_string(joint)) + "' of world '" +
           std::to_string(world);
  };
}

int Batch::nq(int world) const { return impl().seat(world).group->tree().nq(); }
int Batch::nv(int world) const { return impl().seat(world).group->tree().nv(); }

int Batch::group(int world) const {
  Impl& impl = this->impl();
  const Group& group = *impl.seat(world).group;
  if (!impl.numbered) {
    for (const auto& [key, each] : impl.groups) each->set_number(-1);
    int next = 0;
    for (const Impl::Seat& seat : impl.seats)
      if (seat.group->number() < 0) seat.group->set_number(next++);
    impl.numbered = true;
  }
  return group.number();
}

void Batch::Impl::convert(const Tree& tree, Variables given, const double* q, const double* y, double* to, Scratch& own) {
  if (given == Variables::velocities) {
    project_momentum(tree, q, y, to, own.projection);
    clear_locked(tree, to);
  } else {
    evaluate_motions<double>(tree, q, y, own.workspace);
    std::copy_n(own.workspace.v.get(), tree.nv(), to);
  }
}

void Batch::read(std::span<const int> worlds, double* time, double* q, double* p, double* v) const {
  Impl& impl = this->impl();
  if (worlds.empty()) return;
  Group& group = impl.common_rows(worlds);
  const bool momenta = group.variables() == Variables::momenta;
  const int nq = group.tree().nq(), nv = group.tree().nv();
  double* const y = momenta ? p : v;
  const auto slot_of = [&](std::size_t row) { return impl.seats[static_cast<std::size_t>(worlds[row])].slot; };
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    if (time != nullptr) time[row] = group.time(slot_of(row));
    group.get_values(slot_of(row), q != nullptr ? q + place(row, nq) : nullptr, y != nullptr ? y + place(row, nv) : nullptr);
  }
  double* const other = momenta ? v : p;
  if (other == nullptr) return;
  if (momenta && !group.tree().has_loops() && !impl.basis.one_by_one) return impl.read_velocities(group, worlds, v);
  for (Impl::Scratch& each : impl.call.scratches) each.fit(group.tree());
  impl.pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
    const auto row = static_cast<std::size_t>(i);
    Impl::Scratch& own = impl.call.scratches[static_cast<std::size_t>(thread)];
    group.get_values(slot_of(row), own.q.data(), own.v.data());
    Impl::convert(group.tree(), group.variables(), own.q.data(), own.v.data(), other + place(row, nv), own);
  });
}

void Batch::read_loop(std::span<const int> worlds, JointId joint, double* q, double* v) const {
  Impl& impl = this->impl();
  if (worlds.empty()) return;
  const Group& group = impl.common(worlds);
  const Tree& tree = group.tree();
  const int at = is_loop(joint) ? tree.loops().place(joint) : -1;
  MT_REQUIRE(at >= 0, "a joint that closes a loop in these worlds");
  const KindInfo& kind = info(tree.loops()[static_cast<std::size_t>(at)].joint.kind);
  for (Impl::Scratch& each : impl.call.scratches) each.fit(tree);
  impl.pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
    const auto row = static_cast<std::size_t>(i);
    Impl::Scratch& own = impl.call.scratches[static_cast<std::size_t>(thread)];
    const int slot = impl.seat(worlds[row]).slot;
    group.get_values(slot, own.q.data(), own.v.data());
    if (group.variables() == Variables::momenta)
      Impl::convert(tree, Variables::momenta, own.q.data(), own.v.data(), own.v.data(), own);
    double coordinates[7] = {}, velocities[6] = {};
    loop_joint_values(tree, group.time(slot), own.q.data(), own.v.data(), group.turns(slot), own.workspace, at, coordinates,
                      velocities);
    if (q != nullptr) std::copy_n(coordinates, kind.nq, q + place(row, kind.nq));
    if (v != nullptr) std::copy_n(velocities, kind.nv, v + place(row, kind.nv));
  });
}

// Velocities of a batch in momenta, of blocks of worlds in lanes; after common_rows.
void Batch::Impl::read_velocities(Group& group, std::span<const int> worlds, double* v) {
  const int nq = group.tree().nq(), nv = group.tree().nv(), lanes_of_group = group.lanes();
  const auto slot_of = [&](std::size_t row) { return seats[static_cast<std::size_t>(worlds[row])].slot; };
  // Blocks that contain one of the worlds, by their first place in `rows`.
  call.tasks.clear();
  std::vector<std::size_t>& first = call.firsts;
  first.clear();
  for (std::size_t k = 0; k < call.rows.size(); ++k) {
    const int block = slot_of(static_cast<std::size_t>(call.rows[k])) / lanes_of_group;
    if (call.tasks.empty() || call.tasks.back().block != block) call.tasks.push_back({&group, block}), first.push_back(k);
  }
  first.push_back(call.rows.size());
  const auto width = static_cast<std::size_t>(lanes_of_group);
  for (Scratch& each : call.scratches) each.lanes.resize(width * static_cast<std::size_t>(nq + 2 * nv));
  pool.run(static_cast<int>(call.tasks.size()), [&](int thread, int i) {
    double* const rates = call.scratches[static_cast<std::size_t>(thread)].lanes.data();
    double* const velocities = rates + width * static_cast<std::size_t>(nq + nv);
    const batch::Block block = group.block(call.tasks[static_cast<std::size_t>(i)].block);
    steppers.trees[static_cast<std::size_t>(thread)]->rates(group.tree(), group.plan(), block.q, block.y, rates,
                                                            rates + width * static_cast<std::size_t>(nq), velocities);
    for (std::size_t k = first[static_cast<std::size_t>(i)]; k < first[static_cast<std::size_t>(i) + 1]; ++k) {
      const auto row = static_cast<std::size_t>(call.rows[k]);
      const auto lane = static_cast<std::size_t>(slot_of(row) % lanes_of_group);
      for (int f = 0; f < nv; ++f) v[place(row, nv) + static_cast<std::size_t>(f)] = velocities[place(width, f) + lane];
    }
  });
}

void Batch::write(std::span<const int> worlds, const double* time, const double* q, const double* y, Variables given) {
  Impl& impl = changing();
  if (worlds.empty()) return;
  Group& group = impl.common(worlds);
  const Tree& tree = group.tree();
  const int nq = tree.nq(), nv = tree.nv();
  Impl::Scratch& scratch = impl.call.scratches[0];
  scratch.fit(tree);
  // First all checks, then all changes.
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    const JointNamer name = impl.namer(worlds[row]);
    if (time != nullptr) check_time(time[row]);
    if (y != nullptr) check_packed(tree, given == Variables::momenta ? "momenta" : "velocities", false, row_of(y, row, nv), name);
    if (q == nullptr) continue;
    check_packed(tree, "coordinates", true, row_of(q, row, nq), name);
    std::copy_n(q + place(row, nq), nq, scratch.q.data());
    normalise_quaternions(tree, scratch.q, name);
    if (impl.basis.one_by_one) check_limits(tree, row_of(q, row, nq), name);
  }
  // The new numbers of a world, with y as given.
  const auto take = [&](std::size_t row, Impl::Scratch& own) {
    const int slot = impl.seat(worlds[row]).slot;
    group.get_values(slot, own.q.data(), own.v.data());
    if (q != nullptr) std::copy_n(q + place(row, nq), nq, own.q.data());
    if (y != nullptr) std::copy_n(y + place(row, nv), nv, own.v.data());
    const double now = time != nullptr ? time[row] : group.time(slot);
    if (q != nullptr) normalise_quaternions(tree, own.q, {});  // which cannot fail any more
    clear_locked(tree, own.v.data());
    follow_motions(tree, now, own.q.data(), own.v.data());
    return now;
  };
  if (tree.has_loops()) return impl.write_closed(worlds, y != nullptr ? given : group.variables(), take);
  const bool converts = y != nullptr && given != group.variables();
  if (converts) {
    for (Impl::Scratch& each : impl.call.scratches) each.fit(tree);
    impl.call.converted.resize(worlds.size() * static_cast<std::size_t>(nv));
    impl.pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
      const auto row = static_cast<std::size_t>(i);
      Impl::Scratch& own = impl.call.scratches[static_cast<std::size_t>(thread)];
      take(row, own);
      Impl::convert(tree, given, own.q.data(), own.v.data(), impl.call.converted.data() + place(row, nv), own);
    });
  }
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    const double now = take(row, scratch);
    const int slot = impl.seat(worlds[row]).slot;
    group.set_values(slot, now, scratch.q.data(), converts ? impl.call.converted.data() + place(row, nv) : scratch.v.data());
    group.set_diverged(slot, false);
    impl.changed(worlds[row]);
  }
}

// With closed loops. take(row, scratch) writes the new numbers of a world, with y in the variables `given`, and returns its time.
void Batch::Impl::write_closed(std::span<const int> worlds, Variables given,
                               const std::function<double(std::size_t, Scratch&)>& take) {
  Group& group = common(worlds);
  const Tree& tree = group.tree();
  const Names names = names_of(worlds[0], tree);
  std::vector<State> states(worlds.size());
  std::vector<char> closed(worlds.size());
  for (Scratch& each : call.scratches) each.fit(tree);
  pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
    const auto row = static_cast<std::size_t>(i);
    Scratch& own = call.scratches[static_cast<std::size_t>(thread)];
    const double now = take(row, own);
    if (given != group.variables()) convert(tree, given, own.q.data(), own.v.data(), own.v.data(), own);
    State& state = states[row] = State(tree, group.variables());
    state.assign(now, own.q, own.v, tree);
    state.set_turns(group.turns(seat(worlds[row]).slot));
    closed[row] = assemble(tree, basis.model, names, state) ? 0 : 1;
  });
  for (std::size_t row = 0; row < worlds.size(); ++row)
    if (closed[row] == 0) close(worlds[row], tree, states[row]);  // throws
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    const int slot = seat(worlds[row]).slot;
    group.set_state(slot, states[row]);
    group.set_diverged(slot, false);
    changed(worlds[row]);
  }
}

void Batch::momenta_of(std::span<const int> worlds, const double* q, const double* v, double* p, const double* time) const {
  Impl& impl = this->impl();
  if (worlds.empty()) return;
  const Group& group = impl.common(worlds);
  const Tree& tree = group.tree();
  const int nq = tree.nq(), nv = tree.nv();
  for (Impl::Scratch& each : impl.call.scratches) each.fit(tree);
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    const JointNamer name = impl.namer(worlds[row]);
    if (time != nullptr) check_time(time[row]);
    check_packed(tree, "coordinates", true, row_of(q, row, nq), name);
    check_packed(tree, "velocities", false, row_of(v, row, nv), name);
    std::copy_n(q + place(row, nq), nq, impl.call.scratches[0].q.data());
    normalise_quaternions(tree, impl.call.scratches[0].q, name);
  }
  impl.pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
    const auto row = static_cast<std::size_t>(i);
    Impl::Scratch& own = impl.call.scratches[static_cast<std::size_t>(thread)];
    std::copy_n(q + place(row, nq), nq, own.q.data());
    std::copy_n(v + place(row, nv), nv, own.v.data());
    normalise_quaternions(tree, own.q, {});  // which cannot fail any more
    clear_locked(tree, own.v.data());
    follow_motions(tree, time != nullptr ? time[row] : group.time(impl.seat(worlds[row]).slot), own.q.data(), own.v.data());
    Impl::convert(tree, Variables::velocities, own.q.data(), own.v.data(), p + place(row, nv), own);
  });
}

void Batch::set_efforts(std::span<const int> worlds, const double* efforts) {
  Impl& impl = changing();
  if (worlds.empty()) return;
  Group& group = impl.common(worlds);
  const Tree& tree = group.tree();
  const int nv = tree.nv();
  for (std::size_t row = 0; row < worlds.size(); ++row)
    check_packed(tree, "efforts", false, row_of(efforts, row, nv), impl.namer(worlds[row]));
  for (std::size_t row = 0; row < worlds.size(); ++row) {
    std::vector<batch::ExtraEffort>& own = impl.efforts[static_cast<std::size_t>(worlds[row])];
    own.clear();
    for (const int b : tree.order())
      for (int i = 0; i < info(tree.kind(b)).nv; ++i)
        if (const double effort = efforts[place(row, nv) + static_cast<std::size_t>(tree.first_p(b) + i)]; effort != 0)
          own.push_back({tree.joint_of(b), i, effort});
    group.set_efforts(impl.seat(worlds[row]).slot, own);
    impl.efforts_changed(worlds[row]);
  }
}

void Batch::motions(std::span<const int> worlds, BodyId body, double* thirteen) const {
  Impl& impl = this->impl();
  const auto known = [&](int world) { return body.index >= 0 && body.index < impl.seat(world).group->tree().bodies(); };
  if (!worlds.empty() && std::none_of(worlds.begin(), worlds.end(), known))
    throw_error({"none of these worlds has a body number " + std::to_string(body.index), "", "bodies are numbered from 0"});
  const Group* last = nullptr;
  for (const int world : worlds) {
    if (impl.seat(world).group == last) continue;
    last = impl.seat(world).group;
    const Tree& tree = last->tree();
    for (Impl::Scratch& each : impl.call.scratches) {
      if (each.workspace.capacity() < tree.bodies()) each.workspace = Workspace<double>(tree);
      if (each.q.size() < static_cast<std::size_t>(tree.nq())) each.q.resize(static_cast<std::size_t>(tree.nq()));
      if (each.v.size() < static_cast<std::size_t>(tree.nv())) each.v.resize(static_cast<std::size_t>(tree.nv()));
    }
  }
  impl.pool.run(static_cast<int>(worlds.size()), [&](int thread, int i) {
    const auto row = static_cast<std::size_t>(i);
    const Impl::Seat& seat = impl.seat(worlds[row]);
    const Tree& tree = seat.group->tree();
    double* const to = thirteen + 13 * row;
    if (body.index >= tree.bodies() || !tree.alive(body.index)) {
      std::fill_n(to, 13, std::numeric_limits<double>::quiet_NaN());
      return;
    }
    auto& [workspace, projection, q, y, lanes] = impl.call.scratches[static_cast<std::size_t>(thread)];
    seat.group->get_values(seat.slot, q.data(), y.data());
    if (seat.group->variables() == Variables::momenta)
      evaluate_motions<double>(tree, q.data(), y.data(), workspace);
    else
      sweep_velocities<double, true>(tree, q.data(), y.data(), workspace);
    locate_stage(tree, q.data(), workspace);
    const BodyMotion m = user_motion(tree, workspace.bodies[static_cast<std::size_t>(body.index)], body.index);
    const Vec3 &r = m.pose.position, &l = m.linear, &w = m.angular;
    const Quat& o = m.pose.rotation;
    const double all[13] = {r.x, r.y, r.z, o.w, o.x, o.y, o.z, l.x, l.y, l.z, w.x, w.y, w.z};
    std::copy_n(all, 13, to);
  });
}

}  // namespace momentree
