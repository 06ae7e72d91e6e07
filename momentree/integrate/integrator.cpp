#include <momentree/integrate/integrator.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/forces/body_forces.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/forces/soft_stop.hpp>
#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/integrate/method_list.hpp>
#include <momentree/integrate/methods.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {
class Stopwatch {
 public:
  /// `times`: how often what is measured happens; 0: the clock is not read.
  explicit Stopwatch(double& seconds, int times = 1) : seconds_(seconds), times_(times) {
    if (times_ > 0) start_ = std::chrono::steady_clock::now();
  }
  ~Stopwatch() {
    if (times_ > 0) seconds_ += times_ * std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  int times_;
  std::chrono::steady_clock::time_point start_;
};
}  // namespace

void Evaluator::operator()(double t, const double* q, const double* y) noexcept {
  // Reading the clock twice takes half as long as a stage of a robot, so only the first stages and then every 17th are timed. No
  // method has a multiple of 17 stages a step: all of them take their turn.
  constexpr int apart = 17, first = 64;
  const bool timed = stages_ < first || untimed_ + 1 >= apart;
  stages_ = std::min(stages_ + 1, first), ++untimed_;
  const Stopwatch watch(seconds, timed ? std::exchange(untimed_, 0) : 0);
  ++count;
  const bool current = generated_of_ == tree_->revision();
  if (variables_ == Variables::momenta)
    evaluate_stage(*tree_, t, q, y, *workspace_, current ? generated_.momenta : nullptr);
  else if (!(current && generated_.loops != nullptr && evaluate_loop_stage(*tree_, t, q, y, *workspace_, generated_)))
    evaluate_velocity_stage(*tree_, t, q, y, *workspace_, current ? generated_.velocities : nullptr);
}

void Evaluator::without_resistance(const Tree& other, double t, const double* q, const double* p) noexcept {
  const Stopwatch watch(seconds);
  ++count;
  if (other.has_loops()) return evaluate_with_loops(other, t, q, p, *workspace_, LoopRows::kept, false);
  evaluate_for_forces(other, q, p, *workspace_);
  add_joint_forces(other, t, q, *workspace_, false);
  add_body_forces(other, t, q, *workspace_);
}

void Evaluator::operator()(const State& state) noexcept {
  variables_ = state.variables();
  if (workspace_->evaluated == state.stamp()) return;
  const Stopwatch watch(seconds);
  ++count;
  forward_dynamics(*tree_, state, *workspace_);
}

bool Evaluator::close(double t, double* q, double* y, double& energy) noexcept {
  const Stopwatch watch(seconds);
  energy = 0;
  if (tree_->has_loops()) {
    const bool closed = variables_ == Variables::momenta ? close_loops_in_momenta(*tree_, t, q, y, *workspace_, energy)
                                                         : close_loops(*tree_, t, q, y, *workspace_, energy);
    if (!closed) return false;
  }
  return tree_->contacts().empty() || close_contacts(*tree_, t, q, y, *workspace_, energy);
}

void Evaluator::solve(const double* q, const double* p, Workspace<double>& other) noexcept {
  const Stopwatch watch(seconds);
  ++count;
  if (tree_->has_loops())
    find_velocities_with_loops(*tree_, q, p, other, ArmatureSpeeds::none);
  else
    evaluate_rates<double>(*tree_, q, p, other);
}

Integrator::Integrator(const Tree& tree, const StepControl& control)
    : control_(control), proposal_(control.step), bodies_(tree.bodies()) {
  MT_REQUIRE(control.step > 0 && std::isfinite(control.step), "the step is positive and finite");
  MT_REQUIRE(control.rtol > 0 && control.atol > 0 && control.max_step > 0, "rtol, atol and max_step are positive");
}

void Integrator::begin_step(const Evaluator& evaluate, const State& state, double h) noexcept {
  MT_REQUIRE(evaluated_on(evaluate.tree(), state, evaluate.workspace()), stale_workspace(state));
  MT_REQUIRE(evaluate.tree().bodies() <= bodies_, "the method was made for a tree of that many bodies: make another one");
  MT_REQUIRE(std::isfinite(h), "the step is finite");
  stored_in_loops_ = stored_in_loop_stops(evaluate.tree(), evaluate.workspace());
}

std::unique_ptr<Integrator> make_integrator(std::string_view method, const Tree& tree, const StepControl& control) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return std::make_unique<Type>(tree, control);
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return nullptr;
}

double velocity_resolution(const Tree& tree, std::span<const double> q) {
  const auto nv = static_cast<std::size_t>(tree.nv());
  std::vector<double> u(nv, 1.0), p(nv);
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if ((tree.link(b).locked >> i & 1u) != 0) u[static_cast<std::size_t>(tree.first_p(b) + i)] = 0;
  project_momentum(tree, q.data(), u.data(), p.data());
  for (std::size_t i = 0; i < nv; ++i) p[i] *= u[i];
  Workspace<double> workspace(tree);
  evaluate_rates<double>(tree, q.data(), p.data(), workspace);
  double worst = 0x1p-53;
  for (std::size_t i = 0; i < nv; ++i) worst = std::max(worst, std::fabs(workspace.v[i] - 1) * u[i]);
  return worst;
}

bool is_adaptive(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return Type::chooses_steps;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return false;
}

Variables default_variables(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return Type::default_variables;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return Variables::momenta;
}
bool takes_velocities(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return Type::takes_velocities;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return false;
}
bool supports_contact(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return Type::supports_contact;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return false;
}

bool steps_through_contacts(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return Type::steps_through_contacts;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return false;
}
std::string contact_stepping_method() {
  for (const std::string& method : integration_methods())
    if (steps_through_contacts(method)) return method;
  return {};
}

const char* name_of(Variables variables) { return variables == Variables::momenta ? "momenta" : "velocities"; }
std::optional<Variables> variables_of(std::string_view name) {
  for (const Variables one : {Variables::momenta, Variables::velocities})
    if (name == name_of(one)) return one;
  return std::nullopt;
}
std::vector<std::string> variable_names() { return {name_of(Variables::momenta), name_of(Variables::velocities)}; }

namespace {
template <class Method>
constexpr std::string_view other_name() {
  if constexpr (requires { Method::other_name; })
    return Method::other_name;
  else
    return {};
}
}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> all = integration_methods();
#define MOMENTREE_METHOD(name, Type) \
  if (!other_name<Type>().empty()) all.emplace_back(other_name<Type>());
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return all;
}

std::string method_named(std::string_view name) {
#define MOMENTREE_METHOD(method, Type) \
  if (!name.empty() && name == other_name<Type>()) return #method;
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return std::string(name);
}

std::vector<std::string> integration_methods() {
  return {
#define MOMENTREE_METHOD(name, Type) #name,
      MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  };
}

void take_stored(const Tree& tree, const double* q0, const double* q1, EnergyLedger& ledger) noexcept {
  if (!tree.joints_with().forces.empty()) ledger.dissipated -= forces::stored(tree, q1) - forces::stored(tree, q0);
}

void end_step(const Tree& tree, double t, double* q, double* y) noexcept {
  normalise(tree, q);
  follow_motions(tree, t, q, y);
}

void normalise(const Tree& tree, double* q) noexcept {
  for (int b : tree.joints_with().quaternions)
    dispatch(tree.kind(b), [&](auto tag) { decltype(tag)::type::Kernels::normalise(q + tree.first_q(b)); });
}

bool Integrator::sound(const Tree& tree, const double* q0, const double* q, const double* y) noexcept {
  runaway_.reset();
  loops_open_ = false;
  if (plausible(tree, q0, q, y)) return true;
  Runaway worst{-1, 0};
  for (int i = 0; i < tree.nq(); ++i) {
    const double moved = std::fabs(q[i] - q0[i]);
    if (worst.coordinate < 0 || !(moved <= worst.moved)) worst = {i, moved};
    if (!std::isfinite(moved)) break;
  }
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv && worst.moved <= runaway; ++i)
      if (!std::isfinite(y[tree.first_p(b) + i])) worst = {tree.first_q(b), NAN};
  runaway_ = worst;
  return false;
}

bool Integrator::close_loops_of(Evaluator& evaluate, double t, double* q, double* y) noexcept {
  runaway_.reset();
  loops_open_ = !evaluate.close(t, q, y, closing_energy_);
  return !loops_open_;
}

void Integrator::add_gauge(const Evaluator& evaluate, const double* q, double* rates) noexcept {
  if (!evaluate.tree().has_loops() || evaluate.variables() != Variables::momenta) return;
  Workspace<double>& workspace = evaluate.workspace();
  add_gauge_rates(evaluate.tree(), q, workspace, workspace.loops->gauge.data(), rates);
}

void Integrator::book_loops(const Evaluator& evaluate, State& state, EnergyLedger& ledger) const noexcept {
  if (evaluate.tree().has_loops()) state.set_turns(evaluate.workspace().loops->turns);
  ledger.dissipated -= stored_in_loop_stops(evaluate.tree(), evaluate.workspace()) - stored_in_loops_;
  ledger.projection += closing_energy_;
}

bool plausible(const Tree& tree, const double* q0, const double* q, const double* y) noexcept {
  bool fine = true;
  for (int i = 0; i < tree.nq(); ++i) fine &= std::fabs(q[i] - q0[i]) <= runaway;  // false for NaN
  double sum = 0;                                                                  // 0·x is NaN if x is not finite
  for (int i = 0; i < tree.nv(); ++i) sum += 0.0 * y[i];
  return fine && sum == 0;
}

}  // namespace momentree
