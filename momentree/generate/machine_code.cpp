#include <momentree/generate/machine_code.hpp>

#include <algorithm>
#include <cstddef>

#include <momentree/derive/graph_lowering.hpp>
#include <momentree/dynamics/steps/step_library.hpp>
#include <momentree/generate/solve_rows.hpp>
#include <momentree/machine/memory.hpp>
#include <momentree/machine/native.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

namespace {

using machine::CalledWith, machine::Place;

/// What the functions below know of the code that calls them, by the index that it gives them.
struct Context {
  using Function = void (*)(const void* entry, double* memory, int index);
  Function sincos = nullptr, joint = nullptr, solve = nullptr;
  struct Call {
    int loop = -1, arguments = 0, answers = 0;
  };
  std::vector<Call> calls{};
  std::vector<int> begin{}, row{};  ///< of solve_rows
};

const Context& context_of(const void* entry) {
  return *static_cast<const Context*>(static_cast<const CalledWith*>(entry)->context);
}
const LoopCalls& loop_calls_of(const void* entry) {
  return *static_cast<const LoopCalls*>(static_cast<const CalledWith*>(entry)->arguments[3]);
}

/// Of n angles; behind them there is room for n + 3 sines and as many cosines.
void find_sines(const void*, double* angles, int n) {
  sincos_by_fours(
      n, [angles](int i) { return angles[i]; }, angles + n, angles + 2 * n + 3);
}
void ask_joint(const void* entry, double* memory, int index) {
  const Context::Call& call = context_of(entry).calls[static_cast<std::size_t>(index)];
  const LoopCalls& calls = loop_calls_of(entry);
  calls.joint(&calls, call.loop, memory, call.answers, memory + call.arguments);
}
void solve(const void* entry, double* memory, int index) {
  const Context& context = context_of(entry);
  const Context::Call& call = context.calls[static_cast<std::size_t>(index)];
  solve_rows(call.answers, context.begin.data(), context.row.data(), loop_calls_of(entry).least_pivots, memory,
             memory + call.arguments - call.answers, memory + call.arguments);
}

/// The expressions of a kernel as a function that with_arguments() makes one of C.
class KernelLowering : derive::GraphLowering {
 public:
  KernelLowering(const KernelExpressions& kernel, const machine::Target& target)
      : GraphLowering(kernel.expressions.nodes(), target), kernel_(kernel), slot_(nodes_.size(), -1) {
    base_.fill(-1);
  }

  machine::Function run(Context& context) {
    const bool momenta = kernel_.variables == Variables::momenta;
    collect(v, kernel_.v), collect(qdot, kernel_.qdot), collect(ydot, momenta ? kernel_.pdot : kernel_.udot);
    collect(lambda, kernel_.lambda), collect(effort, kernel_.effort);
    choose();
    find_angles();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (is_needed(i) && nodes_[i].operation == Operation::answer && slot_[i] < 0) call(static_cast<int>(i), context);
      if (is_computed(i)) visit(i);
    }
    add_stores();
    return std::move(out_);
  }

 private:
  enum Array : int { q, y, tau, v, qdot, ydot, least, lambda, effort, arrays };
  struct Result {
    int node = 0;
    Array to = arrays;
    int index = 0;
  };
  static constexpr int number = static_cast<int>(sizeof(double));

  /// Where the array is in the arguments of a RatesFunction, VelocityRatesFunction or LoopRatesFunction.
  machine::Base base_of(Array array) const {
    constexpr int of_calls = offsetof(CalledWith, zero), pointer = sizeof(void*);
    switch (array) {
      case least: return {of_calls, offsetof(LoopCalls, least_pivots)};
      case lambda: return {of_calls, offsetof(LoopCalls, lambda)};
      case effort: return {of_calls, offsetof(LoopCalls, effort)};
      case v:
      case tau: return {2 * pointer};
      case qdot: return {(kernel_.loops ? 4 : 3) * pointer};
      case ydot: return {(kernel_.loops ? 5 : 4) * pointer};
      default: return {static_cast<int>(array) * pointer};  // q, y
    }
  }
  Place place(Array array, int index) {
    int& base = base_[at(array)];
    if (base < 0) base = static_cast<int>(out_.bases.size()), out_.bases.push_back(base_of(array));
    return {static_cast<std::int8_t>(base), false, number * index};
  }
  /// In the function's own memory.
  static Place own(int index) { return {Place::frame, false, number * index}; }

  void collect(Array to, const std::vector<int>& nodes) {
    for (std::size_t i = 0; i < nodes.size(); ++i) need(nodes[i]), results_.push_back({nodes[i], to, static_cast<int>(i)});
  }

  bool is_input(std::size_t i) const override { return nodes_[i].operation <= Operation::cosine; }
  Place place_of(std::size_t i) override {
    const auto& n = nodes_[i];
    switch (n.operation) {
      case Operation::constant: return pool(n.value);
      case Operation::q: return place(q, n.a);
      case Operation::p: return place(y, n.a);
      case Operation::tau: return place(tau, n.a);
      case Operation::sine: return own(angles_ + slot_[at(n.a)]);
      case Operation::cosine: return own(2 * angles_ + 3 + slot_[at(n.a)]);
      default: return own(slot_[i]);
    }
  }
  Place least_pivot(int index) override { return place(least, index); }
  std::uint64_t digest_of(std::size_t i, std::uint64_t h) const override {
    return mix(h, static_cast<std::uint64_t>(nodes_[i].a));
  }
  void need_for(std::size_t i) override {
    const auto& n = nodes_[i];
    if (n.operation == Operation::sine || n.operation == Operation::cosine) need(n.a);
    if (n.operation == Operation::answer)
      for (const int argument : kernel_.expressions.calls()[at(kernel_.expressions.call_of(n.a))].arguments) need(argument);
  }

  /// All sines and cosines at once, as in the kernels.
  void find_angles() {
    std::vector<int> all;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const bool trigonometric = nodes_[i].operation == Operation::sine || nodes_[i].operation == Operation::cosine;
      if (!is_needed(i) || !trigonometric || slot_[at(nodes_[i].a)] >= 0) continue;
      slot_[at(nodes_[i].a)] = static_cast<int>(all.size());
      all.push_back(nodes_[i].a);
    }
    if (all.empty()) return;
    angles_ = static_cast<int>(all.size());
    for (const int angle : all) stores_.push_back({visit(at(angle)), own(slot_[at(angle)])});
    out_.memory = 3 * angles_ + 6;
    add_call(offsetof(Context, sincos), 0, angles_);
  }
  /// The call with the answer i.
  void call(int i, Context& context) {
    const int number_of_call = kernel_.expressions.call_of(nodes_[at(i)].a);
    const Expressions::Call& call = kernel_.expressions.calls()[at(number_of_call)];
    const int memory = out_.memory, arguments = static_cast<int>(call.arguments.size());
    for (int k = 0; k < arguments; ++k) stores_.push_back({visit(at(call.arguments[at(k)])), own(memory + k)});
    out_.memory += arguments + call.answers;
    if (context.calls.size() <= at(number_of_call)) context.calls.resize(at(number_of_call) + 1);
    context.calls[at(number_of_call)] = {call.loop, arguments, call.answers};
    add_call(call.loop < 0 ? offsetof(Context, solve) : offsetof(Context, joint), memory, number_of_call);
    const int first = i - (nodes_[at(i)].a - call.first_answer);
    for (int k = 0; k < call.answers; ++k) slot_[at(first + k)] = memory + arguments + k;
  }
  void add_call(std::size_t function, int memory, int index) {
    const int time = static_cast<int>(out_.order.size());
    for (; stored_ < stores_.size(); ++stored_) stores_[stored_].due = time;
    out_.calls.push_back({time, offsetof(CalledWith, context), static_cast<int>(function), number * memory, index});
  }

  void add_stores() {
    for (const Result& one : results_) {
      int value = visit(at(one.node));
      const machine::Value& found = out_.values[at(value)];
      if (found.operation == machine::Operation::load && found.home.base == Place::frame)  // an operation follows every call
        value = operation({machine::Operation::multiply, value, append({machine::Operation::load, -1, -1, -1, pool(1)})});
      stores_.push_back({value, place(one.to, one.index)});
    }
    std::vector<int> known(out_.values.size(), -1);
    for (std::size_t t = 0; t < out_.order.size(); ++t) known[at(out_.order[t])] = static_cast<int>(t) + 1;
    for (std::size_t i = 0; i < stores_.size(); ++i)
      if (const int when = known[at(stores_[i].value)]; when >= 0)
        stores_[i].due = when;
      else if (i >= stored_)
        stores_[i].due = static_cast<int>(out_.order.size());
    std::ranges::stable_sort(stores_, {}, &machine::Store::due);
    out_.stores = std::move(stores_);
  }

  const KernelExpressions& kernel_;
  std::vector<int> slot_;  ///< by node: which angle it is, or where an answer is in the function's memory; −1: neither
  int angles_ = 0;
  std::vector<Result> results_;
  std::vector<machine::Store> stores_;
  std::size_t stored_ = 0;  ///< of those for calls
  std::array<int, arrays> base_{};
};

class OwnKernel : public MachineKernel {
 public:
  explicit OwnKernel(const KernelExpressions& kernel) : context_{find_sines, ask_joint, solve} {
    context_.begin = kernel.begin, context_.row = kernel.rows();
    const std::optional<machine::Target> target = machine::native_target(1, sizeof(double));
    if (!target) return;
    const machine::Function text = KernelLowering(kernel, *target).run(context_);
    const machine::Allocated allocated = machine::allocate(text, *target);
    const auto most = static_cast<std::size_t>(machine::most_numbers);
    if (allocated.frame > machine::most_numbers || std::max(kernel.qdot.size(), 2 * kernel.pdot.size()) > most) return;
    const machine::Bytes bytes = machine::with_arguments(machine::encode(text, allocated, *target), &context_);
    if (bytes.all.size() > machine::most_bytes) return;
    if (const std::uint8_t* const begin = memory_.put(bytes.all); begin != nullptr)
      code_ = reinterpret_cast<void (*)()>(const_cast<std::uint8_t*>(begin) + bytes.entry),
      machine::name_for_profilers(begin, bytes.all.size(), "generated code");
  }
  bool any() const { return code_ != nullptr; }

 private:
  Context context_;
  machine::CodeMemory memory_{4096};
};

}  // namespace

std::unique_ptr<const MachineKernel> MachineKernel::make(const KernelExpressions& kernel) {
  MT_REQUIRE(kernel.loops || kernel.begin.empty(), "with loops, expressions for steps: those for a file have no LoopCalls");
  if (!StepLibrary::of_process().available(StepWidth::one)) return nullptr;
  auto made = std::make_unique<const OwnKernel>(kernel);
  return made->any() ? std::move(made) : nullptr;
}

}  // namespace momentree
