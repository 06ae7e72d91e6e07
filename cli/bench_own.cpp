#include <cli/bench_own.hpp>

#include <cmath>

#include <cli/bench_timing.hpp>
#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>

namespace momentree::cli {

namespace {

constexpr int worlds = 64;

bool locked(const Tree& tree, int b, int freedom) { return (tree.joint(b).locked >> freedom & 1u) != 0; }

/// The model's start, in motion.
State stirred(const Model& model, const Tree& tree) {
  State state = start_state(model, tree);
  std::vector<double> v(static_cast<std::size_t>(tree.nv()));
  for (int b = 0; b < tree.bodies(); ++b)
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if (!locked(tree, b, i)) v[static_cast<std::size_t>(tree.first_p(b) + i)] = 0.1 + 0.2 * ((b + i) % 5);
  project_momentum(tree, state.q().data(), v.data(), state.edit().p.data());
  return state;
}

class Own {
 public:
  Own(const std::string& name, const Model& model)
      : model_(model), tree_(compile(model)), work_(tree_), states_{stirred(model, tree_), stirred(model, tree_)} {
    row.model = name, row.bodies = model.size(), row.freedoms = tree_.nv();
    const std::vector<double> near = moved(tree_, {states_[0].q().begin(), states_[0].q().end()});
    std::copy(near.begin(), near.end(), states_[1].edit().q.begin());
  }

  void evaluate(double budget) {
    int turn = 0;
    row.evaluation = shortest(budget, [&] {
      turn ^= 1;
      evaluate_stage(tree_, 0, q(turn), p(turn), work_);
      keep(work_.pdot.get());
    });
    row.accelerations = shortest(budget, [&] {
      turn ^= 1;
      accelerate(tree_, states_[turn], work_);
      keep(work_.a.get());
    });
    for (const int i : {0, 1}) {
      evaluate_stage(tree_, 0, q(i), p(i), work_);
      const double error = momentum_error(tree_, q(i), p(i), work_);
      if (!(error < 1e-9)) wrong("the velocities found do not belong to the momenta");
      row.error = std::max(row.error, error);
    }
  }

  void evaluate_batch(double budget) {
    try {
      Batch batch(model_, worlds);
      row.batch = shortest(budget, [&] { batch.step(1e-6); }) / (4 * worlds);
      for (int world = 0; world < worlds; ++world)
        if (batch.ran_away(world)) wrong("a world of the batch ran away");
    } catch (const Error& error) {
      row.batch_message = error.what;
    }
  }

  void evaluate_generated(const KernelCache& kernels, double budget) {
    const RatesFunction rates = kernels.find(tree_);
    if (rates == nullptr) return;
    Work<double> other(tree_);
    row.kernels = row.generated = HUGE_VAL;
    int turn = 0;
    const auto begin = Clock::now();
    do {  // in turn, so that what else the machine does befalls both
      row.kernels = std::min(row.kernels, shortest(0, [&] {
                               turn ^= 1;
                               evaluate_rates(tree_, q(turn), p(turn), work_);
                               keep(work_.pdot.get());
                             }));
      row.generated = std::min(row.generated, shortest(0, [&] {
                                 turn ^= 1;
                                 rates(q(turn), p(turn), other.v.get(), other.qdot.get(), other.pdot.get());
                                 keep(other.pdot.get());
                               }));
    } while (since(begin) < budget);
    rates(q(0), p(0), other.v.get(), other.qdot.get(), other.pdot.get());
    if (!(momentum_error(tree_, q(0), p(0), other) < 1e-9)) wrong("generated code finds other velocities than the kernels");
  }

  /// On the first joint from two fifths of the way through on that can be broken, and that can be locked.
  void change(double budget) {
    const int n = tree_.bodies();
    for (int k = 0; k < n && (row.broken.empty() || row.locked.empty()); ++k) {
      const int b = (n * 2 / 5 + k) % n;
      const bool moves = info(tree_.kind(b)).nv > 0 && !locked(tree_, b, 0) && tree_.kind(b) != Kind::free;
      const std::string& name = model_[Body{b}].joint_name;
      if (row.broken.empty() && moves) row.broken = name, row.break_joint = change(Break{{b}}, !has_rotor(b), budget);
      if (row.locked.empty() && moves && !driven(b)) row.locked = name, row.lock_joint = change(Lock{{b}}, false, budget);
    }
  }

  OwnRow row;

 private:
  const double* q(int turn) const { return states_[turn].q().data(); }
  const double* p(int turn) const { return states_[turn].p().data(); }
  /// A rotor turns no more once its joint has broken, and its energy is gone.
  bool has_rotor(int b) const { return tree_.armature()[tree_.first_p(b)] != 0; }
  bool driven(int b) const { return std::ranges::find(tree_.driven_joints(), b) != tree_.driven_joints().end(); }
  [[noreturn]] void wrong(const char* what) const { throw Error{row.model + ": " + what, "", ""}; }

  template <class Change>
  double change(const Change& what, bool keeps_energy, double budget) {
    const bool powered = !tree_.driven_joints().empty();  // motors that hold a motion give and take energy
    double best = HUGE_VAL, before = 0, after = 0;
    const auto start = Clock::now();
    for (int repeat = 0; repeat < 15 || since(start) < budget; ++repeat) {
      Tree tree = tree_;
      State state = states_[0];
      forward_dynamics(tree, state, work_);
      if (repeat == 0) before = totals(tree, state, work_).kinetic;
      const auto at = Clock::now();
      keep(&tree);
      apply(what, tree, state, work_);
      keep(&tree);
      best = std::min(best, since(at));
      if (repeat == 0) after = totals(tree, state, work_).kinetic;
    }
    const double gain = after / before - 1;
    if (!powered && !(gain < 1e-9 && (!keeps_energy || gain > -1e-8))) wrong("the kinetic energy is wrong after a change");
    return best;
  }

  const Model& model_;
  Tree tree_;
  Work<double> work_;
  State states_[2];
};

}  // namespace

OwnRow own_times(const std::string& name, const Model& model, const KernelCache& kernels, double budget) {
  Own own(name, model);
  own.evaluate(budget);
  own.evaluate_batch(budget);
  own.evaluate_generated(kernels, budget);
  own.change(budget);
  return own.row;
}

}  // namespace momentree::cli
