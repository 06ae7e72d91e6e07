#pragma once
// One step of a kind of joint, recorded for a link: from the kind's own functions to functions that can become machine code.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <momentree/derive/recorder.hpp>
#include <momentree/derive/step_arguments.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::derive {

/// The constants of a link that steps read.
struct LinkNumbers {
  std::array<double, 29> placement_and_body{};  ///< from cos_a to R0
  std::array<double, 6> angle_and_geometry{};   ///< from cos_0 to geometry
};
[[nodiscard]] LinkNumbers numbers_of(const LinkConstants& link);
[[nodiscard]] bool same_numbers(const LinkNumbers& numbers, const LinkConstants& link);

/// Which steps a body has: the kind of its joint, its place, and which of its constants are 0, 1 or −1.
struct StepKey {
  Kind kind{};
  bool armature = false;
  Passes passes = Passes::stage_velocities;
  bool gravity = true;  ///< in momenta: there is some
  bool fewest = false;  ///< in the order with the fewest operations; else in that which takes the least time for one world
  BodyPlace place{};
  PlacementShape shape{};
  std::array<std::uint64_t, 2> pattern{};
  friend auto operator<=>(const StepKey&, const StepKey&) = default;
};
/// Without the pattern of the constants.
[[nodiscard]] StepKey key_of(Kind kind, bool armature, BodyPlace place, const LinkConstants& link);
void add_pattern(const LinkNumbers& numbers, StepKey& key);
/// For links with any constants.
void add_general_pattern(StepKey& key);
[[nodiscard]] bool is_general(const StepKey& key);
/// Whether joints of this kind that are used like this have steps: as declared, or with an armature if the kind has kernels for
/// it.
[[nodiscard]] bool has_steps(Kind kind, Variant variant);

/// How a pass hands on its numbers. Outward, a body whose parent comes directly before it can find them in registers.
struct Handing {
  bool adds = false;          ///< inward, to the contributions of other children
  bool in_registers = false;  ///< from the body before
  bool to_registers = false;  ///< to the body that comes next
  bool to_memory = true;      ///< outward, to others
  friend bool operator==(const Handing&, const Handing&) = default;
};

/// The steps of a key, one for each of its passes.
class Step {
 public:
  static constexpr std::size_t most_passes = 3;

  explicit Step(const StepKey& key);

  std::size_t passes() const { return steps_.functions.size(); }
  /// Which pass goes inward.
  std::size_t inward() const { return passes() - 2; }
  /// Numbers in the record of a stage: what its passes store for later ones. In momenta with gravity the first one is given: the
  /// mass of the body and of all bodies outboard (kg).
  int record() const { return mass_ + static_cast<int>(record_.size()) + moments_; }
  /// Numbers that follow from the link's.
  std::size_t constants() const { return constants_.size(); }
  void evaluate_constants(const LinkNumbers& link, double* to) const;
  /// A pass as a function with the arguments of StepFunction.
  [[nodiscard]] machine::Function function(std::size_t pass, const Handing& how, const machine::Target& target) const;
  /// Its operations as text, with the numbers of their equations: what is computed once for each link, then each pass.
  [[nodiscard]] std::string listing() const;

 private:
  class Lowering;  // to instructions
  /// Of an expression: a number, a constant of the link, or a number of the state.
  enum class Level : std::uint8_t { number, link, state };
  struct Constant {
    Operation operation = Operation::constant;
    int a = 0, b = 0;  ///< of an operation: earlier ones; of an input: a number of the link
    double value = 0;
  };

  void find_levels();
  void find_constants();

  Passes kind_;
  int mass_ = 0, moments_ = 0;  ///< numbers at the begin and at the end of the record; the latter are first moments
  std::unique_ptr<Recorder> in_;
  Derived steps_;
  std::vector<Level> levels_;
  std::vector<int> record_;         ///< expressions
  std::vector<int> place_;          ///< by expression: where it is in the record; −1: nowhere
  std::vector<Constant> program_;   ///< finds the constants
  std::vector<int> constants_;      ///< places in the program
  std::vector<int> constant_slot_;  ///< by expression; −1: it is no constant that a pass reads
};

}  // namespace momentree::derive
