#include <cli/bench/own.hpp>

#include <algorithm>
#include <optional>

#include <cli/bench/tables.hpp>
#include <cli/bench/timing.hpp>
#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree::cli {

namespace {

constexpr int worlds = 64;

bool locked(const Tree& tree, int b, int dof) { return (tree.joint(b).locked >> dof & 1u) != 0; }

/// The model's initial state, with motion added.
State with_motion(const Model& model, const Tree& tree) {
  State state = start_state(model, tree);
  std::vector<double> v(static_cast<std::size_t>(tree.nv()));
  for (int b = 0; b < tree.bodies(); ++b)
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if (!locked(tree, b, i)) v[static_cast<std::size_t>(tree.first_p(b) + i)] = 0.1 + 0.2 * ((b + i) % 5);
  {
    const State::Edit edit = state.edit();
    project_momentum(tree, edit.q.data(), v.data(), edit.p.data());
  }
  return state;
}

class Own {
 public:
  Own(const std::string& name, const Model& model)
      : model_(model), tree_(compile(model)), workspace_(tree_), states_{with_motion(model, tree_), with_motion(model, tree_)} {
    row.model = name, row.bodies = tree_.bodies(), row.dofs = tree_.nv();
    const std::vector<double> near = moved(tree_, {states_[0].q().begin(), states_[0].q().end()});
    const State::Edit edit = states_[1].edit();
    std::copy(near.begin(), near.end(), edit.q.begin());
  }

  void evaluate(double budget) {
    const EvaluationRow evaluation = evaluation_time(row.model, tree_, states_[0], budget);
    row.evaluation = evaluation.seconds, row.error = evaluation.error;
    int which = 0;
    row.accelerations = shortest(budget, [&] {
      which ^= 1;
      accelerate(tree_, states_[which], workspace_);
      keep(workspace_.a.get());
    });
    const double error = momentum_error(tree_, states_[which].q().data(), states_[which].p().data(), workspace_);
    if (!(error < 1e-9)) wrong("the velocities found with the accelerations do not match the momenta");
    row.error = std::max(row.error, error);
  }

  void evaluate_batch(double budget) {
    std::optional<Batch> batch;
    try {
      batch.emplace(model_, worlds);
    } catch (const Error& error) {
      row.batch_message = error.problem;
      return;
    }
    if (batch->lanes() == 1) {
      row.batch_message = "batches step its worlds one by one";
      return;
    }
    row.batch = shortest(budget, [&] { batch->step(1e-6); }) / (4 * worlds);
    for (int world = 0; world < worlds; ++world)
      if (batch->diverged(world)) wrong("a world of the batch diverged");
  }

  void evaluate_generated(const KernelCache& kernels, double budget) {
    if (kernels.find(tree_) == nullptr) return;
    const GeneratedRow generated = generated_time(row.model, tree_, states_[0], kernels, budget);
    row.kernels = generated.seconds[0], row.generated = generated.seconds[1];
  }

  /// Uses the first joints, from two fifths of the way on, that can be broken and locked.
  void change(double budget) {
    const int n = tree_.bodies();
    for (int k = 0; k < n && (row.broken.empty() || row.locked.empty()); ++k) {
      const int b = (n * 2 / 5 + k) % n;
      const bool moves = info(tree_.kind(b)).nv > 0 && !locked(tree_, b, 0) && tree_.kind(b) != Kind::free;
      const std::string& name = model_[BodyId{b}].joint_name;
      if (row.broken.empty() && moves) row.broken = name, row.break_joint = change(Break{{b}}, !has_armature(b), budget);
      if (row.locked.empty() && moves && !driven(b)) row.locked = name, row.lock_joint = change(Lock{{b}}, false, budget);
    }
  }

  OwnRow row;

 private:
  /// The armature of a broken joint no longer rotates, and its energy is lost.
  bool has_armature(int b) const { return tree_.tables().armature[tree_.first_p(b)] != 0; }
  bool driven(int b) const { return std::ranges::find(tree_.joints_with().motions, b) != tree_.joints_with().motions.end(); }
  [[noreturn]] void wrong(const char* what) const { throw Error{row.model + ": " + what, "", ""}; }

  template <class Change>
  double change(const Change& what, bool keeps_energy, double budget) {
    const bool powered = !tree_.joints_with().motions.empty();  // prescribed motions do work
    double energy = 0;
    const double best = shortest_change(budget, what, tree_, states_[0], workspace_, energy);
    if (!powered && !(energy < 1 + 1e-9 && (!keeps_energy || energy > 1 - 1e-8)))
      wrong("the kinetic energy is wrong after a change");
    return best;
  }

  const Model& model_;
  Tree tree_;
  Workspace<double> workspace_;
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
