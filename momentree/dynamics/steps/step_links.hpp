#pragma once
// The links of a table's bodies with steps that were derived for them, as machine code or to be interpreted.
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include <momentree/derive/step.hpp>
#include <momentree/dynamics/steps/step_scalar.hpp>
#include <momentree/machine/function.hpp>

namespace momentree {

struct CompiledStep;

/// What the function of an interpreted entry is called with.
struct InterpretedStep {
  using Passes = std::array<machine::Function, step_passes>;
  struct Room {
    void* values = nullptr;  ///< for numbers of the scalar
    std::size_t most = 0;    ///< so many
  };
  const Passes* passes = nullptr;
  const double* constants = nullptr;
  const Room* room = nullptr;
};

#ifdef __wasm__  // browsers have no machine code
class StepLinks {
 public:
  explicit StepLinks(const StepScalar&) {}
  [[nodiscard]] bool available() const { return false; }
  [[nodiscard]] bool serves(Kind, Variant) const { return false; }
  void begin(std::size_t, bool, bool) {}
  [[nodiscard]] int find(Kind, Variant, derive::BodyPlace, const LinkConstants&, int, int) { return -1; }
  std::size_t different() const { return 0; }
  std::size_t record(int) const { return 0; }
  const derive::Step* step(int) const { return nullptr; }
  [[nodiscard]] bool functions(int, const derive::Handing&, const derive::Handing&, StepFunctions&, const void*&) {
    return false;
  }
};
#else
class StepLinks {
 public:
  explicit StepLinks(const StepScalar& scalar) : scalar_(scalar) {}

  /// Whether there are such steps on this machine. These functions throw std::bad_alloc.
  [[nodiscard]] bool available() const;
  /// Whether there are such steps for joints of a kind that are used like this.
  [[nodiscard]] bool serves(Kind kind, Variant variant) const;
  /// Before the links of some number of bodies are looked up. `general`: with steps that serve any constants of a link, of which
  /// there are few. `gravity`: there is some.
  void begin(std::size_t bodies, bool general, bool gravity);
  /// The link of a body that they serve: `same` or `former` if that is still right, else an equal one that was found lately, or
  /// one of its own.
  [[nodiscard]] int find(Kind kind, Variant variant, derive::BodyPlace place, const LinkConstants& link, int same, int former);
  /// The number of different steps since begin().
  std::size_t different() const { return steps_.size(); }
  std::size_t record(int link) const;  ///< numbers
  const derive::Step* step(int link) const;
  /// The steps of a body as entries call them; false: there is no executable memory.
  [[nodiscard]] bool functions(int link, const derive::Handing& outward, const derive::Handing& inward, StepFunctions& to,
                               const void*& constants);

 private:
  /// What bodies with equal links share.
  struct Link {
    derive::LinkNumbers numbers{};
    derive::StepKey form{};  ///< without its pattern
    CompiledStep* step = nullptr;
    unsigned used = 0;          ///< the number of the last rebuilding that found it
    std::size_t constants = 0;  ///< the first one
  };

  StepScalar scalar_;
  bool general_ = false, gravity_ = true;
  unsigned rebuilt_ = 0;
  std::array<int, 8> recent_{};             ///< links that were found lately: ropes and chains alternate between a few
  std::size_t next_ = 0;                    ///< which of these is the oldest
  std::vector<const CompiledStep*> steps_;  ///< different ones
  std::vector<Link> links_;
  std::vector<double> constants_;
  std::vector<float> singles_;  ///< the constants in single precision
  std::deque<InterpretedStep> interpreted_;
  std::map<std::pair<const CompiledStep*, bool>, InterpretedStep::Passes> passes_;  ///< by step and whether it adds inward
  std::vector<double> values_;
  InterpretedStep::Room room_;
};
#endif

}  // namespace momentree
