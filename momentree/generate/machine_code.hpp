#pragma once
// One evaluation of the rates for one topology as one function of machine code.
#include <memory>

#include <momentree/dynamics/steps/rates_function.hpp>
#include <momentree/generate/kernel.hpp>

namespace momentree {

/// The function lives as long as this.
class MachineKernel {
 public:
  /// Null if there is no machine code here (see StepLibrary::available), if it would be too large, or if there is no executable
  /// memory for it. With loops, the expressions are those for steps. Throws std::bad_alloc.
  [[nodiscard]] static std::unique_ptr<const MachineKernel> make(const KernelExpressions& kernel);
  virtual ~MachineKernel() = default;

  /// That of the kernel's variables, or that with loops.
  RatesFunction momenta() const { return reinterpret_cast<RatesFunction>(code_); }
  VelocityRatesFunction velocities() const { return reinterpret_cast<VelocityRatesFunction>(code_); }
  LoopRatesFunction loops() const { return reinterpret_cast<LoopRatesFunction>(code_); }

 protected:
  void (*code_)() = nullptr;
};

}  // namespace momentree
