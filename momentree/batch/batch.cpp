#include <momentree/batch/batch_impl.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <thread>

#include <momentree/base/error.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree {

namespace {
int threads_of(const BatchOptions& options) {
  constexpr int most = 1024;
  if (options.threads < 0 || options.threads > most)
    throw_error({"a batch can't have " + std::to_string(options.threads) + " threads", "",
                 "0 for as many as the machine has, otherwise 1 to " + std::to_string(most)});
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
  return std::clamp(threads, 1, most);
}
const Model& with_bodies(const Model& model) {
  if (model.size() == 0) throw_error({"a batch needs a model with at least one body", "", "add bodies to the model first"});
  return model;
}
}  // namespace

Batch::Batch(const Model& model, int worlds, const BatchOptions& options)
    : impl_(std::make_unique<Impl>(with_bodies(model), options, threads_of(options))) {
  if (worlds < 1) throw_error({"a batch has at least one world", "", "give the number of worlds"});
  if (!model.elements().empty())
    throw_error({"a batch can't step couplings by springs or other elements between joints, and the model has some", "",
                 "let the joints of couplings follow exactly, without a stiffness, or use a sweep"});
  const Tree& tree = impl_->basis.declared;
  impl_->check(tree);
  impl_->seats.resize(static_cast<std::size_t>(worlds));
  impl_->call.tasks.reserve(impl_->seats.size());  // at most a block for each world
  impl_->efforts.resize(static_cast<std::size_t>(worlds));
  Group& group = impl_->group_of(tree);
  if (impl_->basis.one_by_one) {
    if (const std::optional<Overlap> worst = deepest_overlap(model))
      throw_error(
          {worst->text() + " at the start", "", "move one of them, or let them pass through each other by a contact rule"});
    std::vector<int> all(static_cast<std::size_t>(worlds));
    std::iota(all.begin(), all.end(), 0);
    impl_->simulated.resize(all.size());
    impl_->make_simulations(all);
  } else if (tree.has_loops()) {
    impl_->trial.simulation = std::make_unique<Simulation>(impl_->basis.model, impl_->basis.integration);  // closes them
  }
  impl_->at_start = impl_->basis.one_by_one ? impl_->simulated[0]->simulation().world().state()
                    : tree.has_loops()      ? impl_->trial.simulation->world().state()
                                            : start_state(model, tree, impl_->basis.variables);
  for (int world = 0; world < worlds; ++world) {
    impl_->sit(world, group);
    group.set_state(impl_->seat(world).slot, impl_->at_start);
  }
}

void Batch::reset(std::span<const int> worlds) {
  Impl& impl = changing();
  for (const int world : worlds) impl.seat(world);
  if (impl.basis.one_by_one) impl.make_simulations(worlds);
  for (const int world : worlds) {
    const Impl::Seat from = impl.seat(world);
    Group& first = impl.group_of(impl.basis.declared);
    if (&first != from.group) {
      impl.sit(world, first);
      impl.leave(from);
    }
    const int slot = impl.seat(world).slot;
    impl.efforts[static_cast<std::size_t>(world)].clear();
    impl.named.erase(world);
    first.set_efforts(slot, {});
    first.set_state(slot, impl.at_start);
    first.set_diverged(slot, false);
  }
}

namespace {
constexpr const char* only_reads = "an edit of a batch only reads the batch";
}

Batch::~Batch() {
  if (impl_ != nullptr) MT_REQUIRE(!impl_->editing, only_reads);
}
Batch::Batch(Batch&& other) noexcept : impl_(std::move(other.impl_)) {
  if (impl_ != nullptr) MT_REQUIRE(!impl_->editing, only_reads);
}
Batch& Batch::operator=(Batch&& other) noexcept {
  for (const auto* each : {this, &other})
    if (each->impl_ != nullptr) MT_REQUIRE(!each->impl_->editing, only_reads);
  impl_.swap(other.impl_);
  if (this != &other) other.impl_.reset();
  return *this;
}

Batch::Impl& Batch::impl() const {
  MT_REQUIRE(impl_ != nullptr, "the batch has not been moved from");
  return *impl_;
}
Batch::Impl& Batch::changing() const {
  MT_REQUIRE(!impl().editing, only_reads);
  return *impl_;
}
Batch::Editing::Editing(Batch& batch) : impl_(*batch.impl_) { impl_.editing = true; }
Batch::Editing::~Editing() { impl_.editing = false; }

int Batch::worlds() const { return static_cast<int>(impl().seats.size()); }
Isa Batch::isa() const { return impl().steppers.isa; }
Variables Batch::variables() const { return impl().basis.variables; }
Variables Batch::variables(int world) const { return impl().seat(world).group->variables(); }
int Batch::lanes() const { return impl().steppers.lanes; }
int Batch::threads() const { return impl().pool.threads(); }
int Batch::groups() const { return static_cast<int>(impl().groups.size()); }

namespace {
bool is_step(double h) { return h >= 0 && std::isfinite(h); }
constexpr const char* a_step = "a step that is finite and not negative";
}  // namespace

void Batch::step(double h) noexcept {
  MT_REQUIRE(is_step(h), a_step);
  if (changing().basis.one_by_one) return impl_->step_simulations([h](int) { return h; });
  for (const Impl::Seat& seat : changing().seats) seat.group->set_step(seat.slot, h);
  impl_->run();
}

void Batch::step(std::span<const double> h) noexcept {
  MT_REQUIRE(h.size() == changing().seats.size(), "one step for every world");
  for (const double each : h) MT_REQUIRE(is_step(each), a_step);
  if (impl_->basis.one_by_one) return impl_->step_simulations([h](int world) { return h[static_cast<std::size_t>(world)]; });
  for (std::size_t world = 0; world < h.size(); ++world) impl_->seats[world].group->set_step(impl_->seats[world].slot, h[world]);
  impl_->run();
}

double Batch::time(int world) const {
  const Impl::Seat& seat = impl().seat(world);
  return seat.group->time(seat.slot);
}

bool Batch::diverged(int world) const {
  const Impl::Seat& seat = impl().seat(world);
  return seat.group->diverged(seat.slot);
}

const Tree& Batch::tree(int world) const { return impl().seat(world).group->tree(); }

State Batch::state(int world) const {
  const Impl::Seat& seat = impl().seat(world);
  State state(seat.group->tree(), seat.group->variables());
  seat.group->get_state(seat.slot, state);
  return state;
}

void Batch::set_state(int world, const State& state) {
  const Impl::Seat& seat = changing().seat(world);
  MT_REQUIRE(state.topology() == seat.group->tree().revision(), "the state belongs to tree(world)");
  MT_REQUIRE(!state.being_edited(), edited_state);
  if (impl_->basis.one_by_one) check_limits(seat.group->tree(), state.q(), impl_->namer(world));
  if (seat.group->tree().has_loops()) {
    State closed = state;
    impl_->close(world, seat.group->tree(), closed);
    impl_->set_state(seat, closed);
  } else {
    impl_->set_state(seat, state);
  }
  seat.group->set_diverged(seat.slot, false);
  impl_->changed(world);
}

void Batch::Impl::check(const Tree& tree) const {
  if (!basis.one_by_one) return batch::check(tree);
  batch::check_functions(tree);
  if (tree.bodies() != basis.model.size())
    throw_error({"bodies can't be added to a world that is stepped by a simulation of its own", "", "add them to the model"});
}

void Batch::Impl::set_state(const Seat& seat, const State& state) {
  if (state.variables() == seat.group->variables()) return seat.group->set_state(seat.slot, state);
  const Tree& tree = seat.group->tree();
  Scratch& own = call.scratches[0];
  own.fit(tree);
  convert(tree, state.variables(), state.q().data(), state.y().data(), own.v.data(), own);
  seat.group->set_values(seat.slot, state.time(), state.q().data(), own.v.data(), state.turns());
}

void Batch::Impl::close(int world, const Tree& tree, State& state) const {
  if (!tree.has_loops()) return;
  std::optional<Error> error = assemble(tree, basis.model, names_of(world, tree), state);
  if (!error) return;
  error->where += " of world " + std::to_string(world);
  throw_error(std::move(*error));
}

void Batch::set_effort(int world, JointId joint, int dof, double effort) {
  const Impl::Seat& seat = changing().seat(world);
  const Tree& tree = seat.group->tree();
  if (is_loop(joint))
    throw_error({"a joint that closes a loop has no extra efforts", "",
                 "set its parameters, or let another joint of the loop be the one that closes it"});
  MT_REQUIRE(dof >= 0 && dof < info(tree.joint(tree.carrier(joint).index).kind).nv, "the joint has this degree of freedom");
  MT_REQUIRE(std::isfinite(effort), "a finite effort");
  auto& efforts = impl_->efforts[static_cast<std::size_t>(world)];
  std::erase_if(efforts, [&](const batch::ExtraEffort& e) { return e.joint == joint.index && e.dof == dof; });
  if (effort != 0) efforts.push_back({joint.index, dof, effort});
  seat.group->set_efforts(seat.slot, efforts);
  impl_->efforts_changed(world);
}

namespace {
// Whether a loop joint has taken the place, and the number, of that joint, which broke.
bool took_place(const Tree& before, const Tree& after, int joint) {
  const auto loops = before.loops();
  if (std::all_of(loops.begin(), loops.end(), [&](const Loop& loop) { return after.loops().find(loop.id()) != nullptr; }))
    return false;
  const Joint &then = before.joint(before.carrier(joint)), &now = after.joint(after.carrier(joint));
  return !batch::same_pose(then.at, now.at) || !batch::same_pose(then.child_at, now.child_at);
}
}  // namespace

void Batch::Impl::drop_efforts(int world, const Tree& before, const Tree& after) {
  std::erase_if(efforts[static_cast<std::size_t>(world)], [&](const batch::ExtraEffort& e) {
    const int then = before.carrier(e.joint), now = after.carrier(e.joint);
    if (now >= 0 && took_place(before, after, e.joint)) return true;
    return now < 0 || after.joint(now).kind != before.joint(then).kind ||
           after.joint(now).created_by_event != before.joint(then).created_by_event;
  });
  efforts_changed(world);
}

Batch::Out& Batch::take_out(int world) {
  const Impl::Seat& seat = changing().seat(world);
  Out& out = impl_->out;
  out.tree = seat.group->tree();
  if (out.state.variables() != seat.group->variables()) out.state = State(out.tree, seat.group->variables());
  seat.group->get_state(seat.slot, out.state);
  if (out.workspace.capacity() < out.tree.bodies()) out.workspace = Workspace<double>(out.tree);
  forward_dynamics(out.tree, out.state, out.workspace);
  return out;
}

void Batch::put_back(int world) {
  const Impl::Seat from = impl_->seat(world);
  Out& out = impl_->out;
  MT_REQUIRE(!out.state.being_edited(), edited_state);
  const bool changed = out.tree.revision() != from.group->tree().revision();
  if (changed) impl_->check(out.tree);
  MT_REQUIRE(out.state.topology() == out.tree.revision(), "after the edit, the state still belongs to the tree");
  impl_->close(world, out.tree, out.state);  // may throw
  if (changed) {
    impl_->drop_efforts(world, from.group->tree(), out.tree);
    Group& to = impl_->group_of(out.tree);
    if (&to != from.group) {
      const bool away = from.group->diverged(from.slot);
      impl_->sit(world, to);
      to.set_diverged(impl_->seat(world).slot, away);
      impl_->leave(from);
    }
    to.set_efforts(impl_->seat(world).slot, impl_->efforts[static_cast<std::size_t>(world)]);
  }
  impl_->set_state(impl_->seat(world), out.state);
  impl_->changed(world);
}

}  // namespace momentree
