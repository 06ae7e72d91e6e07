#pragma once
// What a method calls that steps through contacts instead of locating them.
#include <momentree/dynamics/evaluate.hpp>

namespace momentree {

struct EnergyLedger;

class StepContacts {
 public:
  virtual ~StepContacts() = default;
  /// Completes a step of h seconds. `state` is the motion at its end without contacts during the step; the impulses of contacts
  /// change its velocities, and its coordinates by what these bring about until then.
  virtual void apply(State& state, EnergyLedger& ledger, double h) = 0;
  /// Several steps may be tried from one state: notes what was remembered of the step before, and returns to that.
  virtual void note_start() = 0;
  virtual void return_to_start() = 0;
};

}  // namespace momentree
