// No kernel of any scalar type computes with memory that it has not written. Fresh memory contains signalling NaNs: arithmetic
// with one raises a processor flag, even if the result is never read. Values that only control decisions (an index, a node of an
// expression) make results differ or stop the program. Under valgrind, which tracks memory itself, valgrind reports the errors.
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/batch/group.hpp>
#include <momentree/dynamics/count.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/generate/kernel.hpp>
#include <tests/memory/bits.hpp>
#include <tests/memory/filled_memory.hpp>
#include <tests/memory/random_worlds.hpp>

namespace momentree::memory {

namespace {

constexpr std::uint64_t worlds = 240;

/// Calls find(work, found) twice, in memory filled with different patterns.
template <class Find>
void check_double(const Tree& tree, const char* what, const Find& find) {
  CAPTURE(std::string(what));
  Bits found[2];
  {
    const Filled fill(Fill::doubles);
    Workspace<double> workspace(tree);
    watch();
    find(workspace, found[0]);
    CHECK_FALSE(signalled());
  }
  Workspace<double> workspace(tree);
  find(workspace, found[1]);
  CHECK((found[0] == found[1]));
}

void add_rates(const Tree& tree, const Workspace<double>& workspace, Bits& found) {
  found.add(workspace.v.get(), tree.nv()), found.add(workspace.qdot.get(), tree.nq()), found.add(workspace.pdot.get(), tree.nv());
}

}  // namespace

TEST_CASE("arithmetic on filled memory is detected, moving it is not") {
  if (off()) return;
  for (const Fill fill : {Fill::doubles, Fill::floats}) {
    const Filled filled(fill);
    const auto numbers = std::make_unique_for_overwrite<double[]>(4);
    float halves[2];
    std::memcpy(halves, numbers.get(), sizeof halves);
    volatile double sink = 0;
    volatile float narrow = 0;
    watch();
    const double moved[2] = {numbers[0], numbers[1]};
    CHECK_FALSE(signalled());
    if (fill == Fill::doubles) sink = moved[0] + moved[1];
    if (fill == Fill::floats) narrow = halves[0] + 1.0F;
    CHECK(signalled());
    static_cast<void>(sink), static_cast<void>(narrow);
  }
}

TEST_CASE("double: stages, motions, accelerations, wrenches, poses") {
  Seen seen;
  for (std::uint64_t seed = 0; seed < worlds; ++seed) {
    CAPTURE(seed);
    const Changed world = random_world(seed);
    const Tree& tree = world.tree;
    const double *const q = world.state.q().data(), *const p = world.state.p().data();
    seen.note(tree);
    check_double(tree, "a stage", [&](Workspace<double>& workspace, Bits& found) {
      evaluate_rates(tree, q, p, workspace);
      add_rates(tree, workspace, found);
    });
    check_double(tree, "motions", [&](Workspace<double>& workspace, Bits& found) {
      evaluate_motions(tree, q, p, workspace);
      add_rates(tree, workspace, found);
      for (const int b : tree.order()) {
        const BodySweep<double>& body = workspace.motions[static_cast<std::size_t>(b)];
        found.add(body.velocity), found.add(body.articulated);
      }
    });
    check_double(tree, "a stage with forces", [&](Workspace<double>& workspace, Bits& found) {
      evaluate_stage(tree, 0.3, q, p, workspace);
      add_rates(tree, workspace, found);
      found.add(workspace.power.dissipated), found.add(workspace.power.work);
    });
    check_double(tree, "accelerations", [&](Workspace<double>& workspace, Bits& found) {
      accelerate(tree, world.state, workspace);
      locate_bodies(tree, world.state, workspace);
      found.add(workspace.a.get(), tree.nv());
      for (const int b : tree.order()) {
        double effort[6] = {};
        joint_effort(tree, world.state, workspace, tree.inboard_joint({b}), effort);
        found.add(effort, 6);
        found.add(transmitted_wrench(tree, workspace, b)), found.add(felt_acceleration(tree, q, workspace, b));
        const BodyAcceleration a = body_acceleration(tree, world.state, workspace, BodyId{b});
        found.add(a.linear), found.add(a.angular);
        const BodyMotion motion = user_motion(tree, workspace.bodies[static_cast<std::size_t>(b)], b);
        found.add(motion.pose.position), found.add(motion.linear), found.add(motion.angular);
      }
      const Totals sum = totals(tree, world.state, workspace);
      found.add(sum.kinetic), found.add(sum.potential), found.add(sum.linear), found.add(sum.angular);
    });
  }
  CHECK(seen.missing() == "");
}

TEST_CASE("lanes: rates and steps of every instruction set and precision") {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512})
    for (const Variables variables : {Variables::momenta, Variables::velocities})
      for (const Precision precision : {Precision::float64, Precision::float32}) {
        if (!batch::available(isa)) continue;
        CAPTURE(static_cast<int>(isa));
        CAPTURE(static_cast<int>(precision));
        CAPTURE(static_cast<int>(variables));
        long steps = 0;
        for (std::uint64_t seed = 0; seed < worlds; ++seed) {
          CAPTURE(seed);
          const Changed world = random_world(seed);
          const Tree& tree = world.tree;
          bool can_step = true;
          try {
            batch::check(tree);
          } catch (const Error&) {
            can_step = false;
          }
          steps += can_step;
          const auto find = [&](Fill fill, Bits& found) {
            std::unique_ptr<batch::TreeStepper> stepper;
            {
              const Filled filled(fill);
              stepper = batch::make_stepper(isa, precision, tree, variables);
            }
            const batch::TopologyPlan plan(tree, stepper->scalars());
            const int lanes = stepper->lanes();
            const auto spread = [&](std::span<const double> of_one) {
              std::vector<double> all;
              for (const double x : of_one) all.insert(all.end(), static_cast<std::size_t>(lanes), x);
              return all;
            };
            auto q = spread(world.state.q()), p = spread(world.state.p());
            auto qdot = q, pdot = p, v = p;
            std::vector<double> time(static_cast<std::size_t>(lanes)), h(time.size(), 1e-3);
            std::vector<unsigned char> diverged(time.size());
            watch();
            stepper->rates(tree, plan, q.data(), p.data(), qdot.data(), pdot.data(), v.data());
            if (can_step) stepper->step(tree, plan, {q.data(), p.data(), nullptr, time.data(), h.data(), diverged.data()});
            if (fill != Fill::zeros) CHECK_FALSE(signalled());
            for (const auto& numbers : {q, p, qdot, pdot, v}) found.add(numbers.data(), static_cast<int>(numbers.size()));
          };
          Bits found[2];
          find(precision == Precision::float64 ? Fill::doubles : Fill::floats, found[0]);
          find(Fill::zeros, found[1]);
          CHECK((found[0] == found[1]));
        }
        CHECK(steps > 50);
      }
}

TEST_CASE("operation counts and symbolic expressions") {
  const std::uint64_t some = off() ? worlds / 6 : worlds;  // graphs are slow under valgrind
  for (std::uint64_t seed = 0; seed < some; ++seed) {
    CAPTURE(seed);
    const Tree tree = random_world(seed).tree;
    Operations counted[2];
    {
      const Filled fill(Fill::doubles);
      watch();
      counted[0] = count_operations(tree);
      CHECK_FALSE(signalled());
    }
    counted[1] = count_operations(tree);
    CHECK(counted[0].total() == counted[1].total());
    KernelExpressions one;
    {
      const Filled fill(Fill::quiet);
      one = kernel_expressions(tree);
    }
    const KernelExpressions other = kernel_expressions(tree);
    CHECK((one.expressions.nodes() == other.expressions.nodes()));
    CHECK((one.results() == other.results()));
    {
      const Filled filled(Fill::quiet);
      one = velocity_expressions(tree);
    }
    const KernelExpressions again = velocity_expressions(tree);
    CHECK((one.expressions.nodes() == again.expressions.nodes()));
    CHECK((one.results() == again.results()));
  }
}

}  // namespace momentree::memory
