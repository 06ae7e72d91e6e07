#include "simulation_object.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <nanobind/ndarray.h>

#include <momentree/simulate/run_state.hpp>

namespace momentree::python {

nb::object state_view(const std::shared_ptr<StateArrays>& arrays, std::vector<double>& numbers, const char* name) {
  const nb::object owner = nb::cast(arrays);
  const nb::ndarray<nb::numpy, double, nb::ndim<1>> array(numbers.data(), {numbers.size()}, owner);
  return python_class("_views", "StateView").attr("_of")(nb::cast(array, nb::rv_policy::reference), owner, name);
}

bool StateArrays::Numbers::written() const {
  return !now.empty() && std::memcmp(now.data(), last.data(), now.size() * sizeof(double)) != 0;
}

SimulationObject::SimulationObject(std::shared_ptr<const io::Scenario> scenario, std::unique_ptr<io::Session> session)
    : scenario_(std::move(scenario)), session_(std::move(session)) {
  watch();
}

SimulationObject::SimulationObject(SimulationObject& from)
    : std::enable_shared_from_this<SimulationObject>(),
      scenario_(from.scenario_),
      session_(from.session_),
      branch_(from.simulation().branch()) {
  watch();
}

SimulationObject::~SimulationObject() = default;

void SimulationObject::watch() {
  simulation().watch([this](double time) { return look_around(time); });
}

// After every step: now and then, signals and the progress display.
bool SimulationObject::look_around(double time) {
  if (pending_) return false;
  if (++steps_since_look_ < 16) return true;
  steps_since_look_ = 0;
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_ < std::chrono::milliseconds(50)) return true;
  looked_ = now;
  const nb::gil_scoped_acquire gil;
  const Within observing(*this, Inside::observer);
  return guarded([&] {
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
    if (progress.is_valid() && !progress.is_none()) progress(time);
  });
}

void SimulationObject::rethrow() {
  if (!pending_) return;
  Simulation& sim = simulation();
  if (sim.result().status == Status::diverged) sim.restore(sim.snapshot());  // by the NaN of a function that failed: it may go on
  std::rethrow_exception(std::exchange(pending_, nullptr));
}

void SimulationObject::throw_run_error(const RunResult& result) {
  const nb::object type = python_class("_errors", "RunError");
  PyErr_SetObject(type.ptr(), type(result.reason).ptr());
  nb::raise_python_error();
}

RunResult SimulationObject::run_until(double time) {
  RunResult result;
  looked_ = std::chrono::steady_clock::now();
  {
    const nb::gil_scoped_release free;
    result = simulation().run_until(time);
  }
  rethrow();
  return result;
}

void SimulationObject::step(double dt) {
  if (dt == std::numeric_limits<double>::infinity()) refuse("a step can't be infinite");
  RunResult result;
  {
    const nb::gil_scoped_release free;
    result = simulation().step(dt);
  }
  rethrow();
  if (!result && result.status != Status::interrupted) throw_run_error(result);
}

namespace {

std::vector<int> layout_of(const Tree& tree) {
  std::vector<int> layout(static_cast<std::size_t>(tree.bodies()), -1);
  for (int j = 0; j < tree.bodies(); ++j)
    if (const int body = tree.carrier(j); body >= 0) layout[static_cast<std::size_t>(j)] = static_cast<int>(tree.kind(body));
  return layout;
}

// True if the joint exists and has a function.
bool is_driven(const World& world, const std::string& joint) {
  const Tree& tree = world.tree();
  const int number = world.find_joint(joint);
  if (number < 0) return false;
  const int place = is_loop({number}) ? tree.loops().place({number}) : tree.carrier(number);
  return place >= 0 && (is_loop({number}) ? tree.function(tree.loops()[place].joint) : tree.function(place)) != nullptr;
}

}  // namespace

bool SimulationObject::same_layout() {
  const Tree& tree = simulation().world().tree();
  if (arrays_->topology == tree.revision()) return true;
  if (arrays_->layout != layout_of(tree)) return false;
  arrays_->topology = tree.revision();
  return true;
}

const std::shared_ptr<StateArrays>& SimulationObject::arrays() {
  const World& world = simulation().world();
  if (arrays_ && !same_layout()) drop_arrays();
  if (!arrays_) {
    arrays_ = std::make_shared<StateArrays>();
    arrays_->topology = world.tree().revision();
    arrays_->layout = layout_of(world.tree());
    const auto nv = static_cast<std::size_t>(world.tree().nv());
    arrays_->effort.now.assign(nv, 0.0), arrays_->effort.last.assign(nv, 0.0);
    fill_efforts();
    arrays_->qdot.resize(static_cast<std::size_t>(world.tree().nq())), arrays_->pdot.resize(nv);
    pull();
  }
  return arrays_;
}

// The efforts as the inputs have them.
void SimulationObject::fill_efforts() {
  const Tree& tree = simulation().world().tree();
  std::vector<double>& efforts = arrays_->effort.now;
  std::fill(efforts.begin(), efforts.end(), 0.0);
  for (int j = 0; j < tree.bodies() && !inputs_.empty(); ++j) {
    const int body = tree.carrier(j);
    const std::shared_ptr<JointInput> input = body < 0 ? nullptr : input_of(j);
    if (!input) continue;
    if (static_cast<int>(input->extra.size()) != info(tree.kind(body)).nv) continue;
    std::copy(input->extra.begin(), input->extra.end(), efforts.begin() + tree.first_p(body));
  }
  arrays_->effort.last = efforts;
}

void SimulationObject::drop_arrays() {
  if (!arrays_) return;
  for (StateArrays::Numbers* numbers : {&arrays_->q, &arrays_->v, &arrays_->p, &arrays_->effort})
    std::fill(numbers->now.begin(), numbers->now.end(), std::numeric_limits<double>::quiet_NaN());
  std::fill(arrays_->qdot.begin(), arrays_->qdot.end(), std::numeric_limits<double>::quiet_NaN());
  std::fill(arrays_->pdot.begin(), arrays_->pdot.end(), std::numeric_limits<double>::quiet_NaN());
  arrays_->alive = false;
  views = {};
  arrays_.reset();
}

void SimulationObject::pull() {
  if (!arrays_) return;
  const World& world = simulation().world();
  if (!same_layout()) return drop_arrays();
  const auto copy = [](std::span<const double> from, StateArrays::Numbers& to) {
    if (to.now.size() != from.size()) to.now.resize(from.size()), to.last.resize(from.size());  // first use: no view yet
    if (from.empty()) return;
    std::memcpy(to.now.data(), from.data(), from.size_bytes());
    std::memcpy(to.last.data(), from.data(), from.size_bytes());
  };
  copy(world.state().q(), arrays_->q);
  copy(world.p(), arrays_->p);
  if (arrays_->with_v) copy(world.v(), arrays_->v);
}

bool SimulationObject::written() const {
  if (!arrays_) return false;
  return arrays_->q.written() || arrays_->p.written() || (arrays_->with_v && arrays_->v.written()) ||
         (arrays_->with_effort && arrays_->effort.written());
}

void SimulationObject::push() {
  if (!arrays_) return;
  const bool q = arrays_->q.written(), p = arrays_->p.written(), v = arrays_->with_v && arrays_->v.written();
  if (arrays_->with_effort && arrays_->effort.written()) {
    for (const double x : arrays_->effort.now)
      if (!std::isfinite(x)) {
        arrays_->effort.now = arrays_->effort.last;
        refuse("effort: a number that was written is not finite");
      }
    arrays_->effort.last = arrays_->effort.now;
    set_efforts(arrays_->effort.now);
  }
  if (!q && !p && !v) return;
  Simulation& sim = simulation();
  try {
    if (p && v) refuse("both sim.v and sim.p were written", "momenta follow from velocities: write one of them");
    // Writing q keeps the velocities: they are what a user thinks of as the motion. Momenta that are written are taken as they
    // are.
    std::vector<double> y = p ? arrays_->p.now : arrays_->v.now;
    if (!p && !v) {
      const Numbers now = sim.world().v();
      y.assign(now.begin(), now.end());
    }
    sim.adjust(arrays_->q.now, y, p ? Variables::momenta : Variables::velocities);
  } catch (...) {
    pull();
    throw;
  }
  pull();
}

std::shared_ptr<SimulationObject::JointInput> SimulationObject::input_of(int joint) {
  const auto found = inputs_.find(simulation().world().joint_name({joint}));
  return found != inputs_.end() ? found->second : nullptr;
}

void SimulationObject::install(int joint, const std::shared_ptr<JointInput>& input) {
  const std::string name(simulation().world().joint_name({joint}));
  if (input->function.is_valid() || !input->extra.empty())
    simulation().drive_all(name, drive_of(input));
  else
    simulation().drive_all(name, {});
  inputs_[name] = input;
}

void SimulationObject::set_drive(const std::string& joint, nb::handle function) {
  Simulation& sim = simulation();
  const int number = sim.world().find_joint(joint);
  if (number < 0) sim.drive_all(joint, [](const EvaluationContext&, std::span<double>) {});  // throws, and names the nearest
  // A new input: a branch may share the former one.
  auto input = std::make_shared<JointInput>();
  if (const std::shared_ptr<JointInput> before = input_of(number)) input->extra = before->extra;
  if (!function.is_none()) input->function = function;
  install(number, input);
}

void SimulationObject::set_efforts(const std::vector<double>& packed) {
  Simulation& sim = simulation();
  const Tree& tree = sim.world().tree();
  std::vector<JointDriver> fresh;
  for (int j = 0; j < tree.bodies(); ++j) {
    const int body = tree.carrier(j);
    if (body < 0) continue;
    const auto nv = static_cast<std::size_t>(info(tree.joint(body).kind).nv);
    const double* const numbers = packed.data() + tree.first_p(body);
    std::shared_ptr<JointInput> input = input_of(j);
    const bool any = std::any_of(numbers, numbers + nv, [](double x) { return x != 0; });
    if (!any && (!input || input->extra.empty())) continue;
    const bool had = input && input->extra.size() == nv && tree.function(body) != nullptr;
    const bool changed = had && !std::equal(numbers, numbers + nv, input->extra.begin());
    const std::string name(sim.world().joint_name({j}));
    if (!input) input = inputs_[name] = std::make_shared<JointInput>();
    input->extra.assign(numbers, numbers + nv);
    // The engine must evaluate the state anew: one driver does that where only numbers have changed.
    if (!had || (changed && fresh.empty())) fresh.push_back({name, drive_of(input)});
  }
  if (!fresh.empty()) sim.drive_all(std::move(fresh));
}

bool SimulationObject::has_functions() {
  const World& world = simulation().world();
  if (!world.tree().loads().functions.empty()) return true;
  for (const EventQueue::Entry& event : scheduled(simulation()))
    if (event.condition && make_quantity(event.condition->what->key()) == nullptr) return true;
  return std::any_of(inputs_.begin(), inputs_.end(),
                     [&](const auto& each) { return each.second->function.is_valid() && is_driven(world, each.first); });
}

std::vector<std::pair<int, std::vector<double>>> SimulationObject::efforts() {
  const World& world = simulation().world();
  std::vector<std::pair<int, std::vector<double>>> all;
  for (const auto& [joint, input] : inputs_)
    if (!input->extra.empty() && is_driven(world, joint)) all.emplace_back(world.find_joint(joint), input->extra);
  return all;
}

SimulationObject::Inputs SimulationObject::copy_inputs() const {
  Inputs copies;
  for (const auto& [joint, input] : inputs_) copies.emplace(joint, std::make_shared<JointInput>(*input));
  return copies;
}

void SimulationObject::set_inputs(const Inputs& inputs) {
  inputs_ = {};
  const World& world = simulation().world();
  std::vector<JointDriver> drivers;
  for (const auto& [joint, input] : inputs) {
    const auto own = inputs_[joint] = std::make_shared<JointInput>(*input);
    if (is_driven(world, joint)) drivers.push_back({joint, drive_of(own)});
  }
  if (!drivers.empty()) simulation().drive_all(std::move(drivers));
  if (arrays_ && same_layout()) fill_efforts();
}

namespace {
thread_local SimulationObject* in_use = nullptr;
}

SimulationObject* SimulationObject::current() { return in_use; }

Use::Use(SimulationObject& object, Access access) : object_(object), access_(access) {
  const std::thread::id me = std::this_thread::get_id();
  std::thread::id user;
  outermost_ = object.user.compare_exchange_strong(user, me, std::memory_order_acquire);
  if (outermost_) {
    before_ = std::exchange(in_use, &object);
    try {
      object.push();
    } catch (...) {
      in_use = before_;
      object.user.store({}, std::memory_order_release);
      throw;
    }
    return;
  }
  if (user != me)
    refuse("the simulation is being used by another thread",
           "give each thread its own: sim.branch(), or a simulation of the same model");
  switch (object.inside) {
    case Inside::nothing:  // Python code that an operation runs to convert its arguments
      if (access != Access::read)
        refuse("the simulation was used while it was reading the arguments of another call",
               "convert them beforehand, for example with numpy.array");
      break;
    case Inside::drive:
      refuse("a function that drives a joint or acts on a body used its simulation",
             "it may read only the context that is passed to it");
    case Inside::measure:
      refuse("a function that measures a condition used its simulation", "it may read only the world that is passed to it");
    case Inside::observer:
      if (access == Access::change || object.written())
        refuse("an observer tried to change its simulation during a run",
               "return False to end the run and make the change afterwards, or schedule it: sim.at(sim.time).then(…)");
      object.pull();
  }
}

Use::~Use() {
  if (!outermost_) return;
  if (access_ != Access::read) {
    try {
      object_.pull();
    } catch (...) {  // out of memory
      object_.drop_arrays();
    }
  }
  in_use = before_;
  object_.user.store({}, std::memory_order_release);
}

}  // namespace momentree::python
