// A pass of a recorded step as a function for machine code.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <momentree/derive/step.hpp>
#include <momentree/joint/pass_data.hpp>

namespace momentree::derive {

namespace {

using machine::Place;

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The numbers of an Inboard and of a Motion by name, in the order of their memory.
constexpr std::string_view sum_numbers[] = {"M.A.xx", "M.A.yy", "M.A.zz", "M.A.xy", "M.A.xz", "M.A.yz", "M.B.xx", "M.B.xy",
                                            "M.B.xz", "M.B.yx", "M.B.yy", "M.B.yz", "M.B.zx", "M.B.zy", "M.B.zz", "M.J.xx",
                                            "M.J.yy", "M.J.zz", "M.J.xy", "M.J.xz", "M.J.yz", "D.l.x",  "D.l.y",  "D.l.z",
                                            "D.h.x",  "D.h.y",  "D.h.z",  "mc.x",   "mc.y",   "mc.z"};
constexpr std::string_view motion_numbers[] = {"v.x", "v.y", "v.z", "w.x", "w.y", "w.z"};
constexpr std::string_view output_numbers[] = {"velocity.v.x", "velocity.v.y", "velocity.v.z", "velocity.w.x", "velocity.w.y",
                                               "velocity.w.z", "gravity.x",    "gravity.y",    "gravity.z"};
constexpr std::string_view moment_numbers[] = {"x", "y", "z"};
static_assert(offsetof(Inboard<double>, M.A.yz) == 5 * 8 && offsetof(Inboard<double>, M.B.yx) == 9 * 8 &&
              offsetof(Inboard<double>, M.J.xx) == 15 * 8 && offsetof(Inboard<double>, D.h.z) == 26 * 8 &&
              offsetof(Inboard<double>, mc.z) == 29 * 8 && offsetof(Motion<double>, w.z) == 5 * 8 &&
              offsetof(Outboard<double>, gravity.z) == 8 * 8);

}  // namespace

class Lowering {
 public:
  Lowering(const Step& step, std::size_t pass, const Handing& how, const machine::Target& target)
      : step_(step), nodes_(step.in_->expressions.nodes()), pass_(pass), how_(how), target_(target) {}

  machine::Function run() {
    find_stores();
    find_needed();
    choose_fused();
    for (int i : step_.steps_.functions[pass_].first) {
      while (nodes_[at(i)].operation == Operation::negative) i = nodes_[at(i)].a;
      if (needed_[at(i)] && !fused_[at(i)]) visit(at(i));
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (needed_[i] && !fused_[i] && !is_input(i)) visit(i);
    add_stores();
    return std::move(out_);
  }

 private:
  /// An array of StepArrays, or what a body has there.
  enum Array : int {
    q,
    cos,
    sin,
    u,
    qdot,
    a,
    p,
    pdot,
    record,
    sum_in,
    sum_to,
    motion_in,
    motion_to,
    armature,
    constants,
    arrays
  };

  static machine::Base base_of(Array array) {
    switch (array) {
#define MOMENTREE_BASE(name, place, memory) \
  case name: return {offsetof(StepEntry, place), offsetof(StepArrays, memory)};
      MOMENTREE_BASE(q, q, q)
      MOMENTREE_BASE(cos, angle, cos)
      MOMENTREE_BASE(sin, angle, sin)
      MOMENTREE_BASE(u, dof, u)
      MOMENTREE_BASE(qdot, q, qdot)
      MOMENTREE_BASE(a, dof, a)
      MOMENTREE_BASE(p, dof, p)
      MOMENTREE_BASE(pdot, dof, pdot)
      MOMENTREE_BASE(record, record, records)
      MOMENTREE_BASE(sum_in, in, sums)
      MOMENTREE_BASE(sum_to, to, sums)
      MOMENTREE_BASE(motion_in, in, motions)
      MOMENTREE_BASE(motion_to, to, motions)
      MOMENTREE_BASE(armature, dof, armature)
#undef MOMENTREE_BASE
      default: return {offsetof(StepEntry, constants), -1};
    }
  }

  struct Slot {
    Array array = arrays;
    int index = 0;
  };
  /// Where a number is that a pass reads or stores.
  Slot slot_of(std::string_view name, bool stored) const {
    const auto indexed = [&](std::string_view prefix) { return name.starts_with(prefix); };
    const auto index = [&] { return std::atoi(name.data() + name.find('[') + 1); };
    const auto in = [](std::span<const std::string_view> all, std::string_view part) {
      const auto found = std::ranges::find(all, part);
      return found == all.end() ? -1 : static_cast<int>(found - all.begin());
    };
    if (indexed("j.q[")) return {q, index()};
    if (indexed("j.c[")) return {cos, index()};
    if (indexed("j.s[")) return {sin, index()};
    if (indexed("u[")) return {u, index()};
    if (indexed("qdot[")) return {qdot, index()};
    if (indexed("tau[") || indexed("udot[")) return {a, index()};
    if (indexed("p[")) return {p, index()};
    if (indexed("pdot[")) return {pdot, index()};
    if (indexed("out.")) return {stored ? motion_to : motion_in, in(output_numbers, name.substr(4))};
    if (indexed("w.mc.")) return {record, step_.record() - 3 + in(moment_numbers, name.substr(5))};
    if (indexed("velocity.")) return {stored ? motion_to : motion_in, in(motion_numbers, name.substr(9))};
    if (indexed("to.")) return {sum_to, in(sum_numbers, name.substr(3))};
    MT_REQUIRE(indexed("a."), "a number that passes read or store");
    const int motion = in(motion_numbers, name.substr(2));
    if (motion >= 0) return {stored ? motion_to : motion_in, motion};
    return {sum_in, in(sum_numbers, name.substr(2))};
  }

  struct Result {
    int node = 0;
    Slot to;
  };

  void find_stores() {
    const Function& f = step_.steps_.functions[pass_];
    for (const auto* list : {&f.stores, &f.last})
      for (const auto& one : *list) {
        const Slot to = slot_of(one.to, true);
        results_.push_back({one.node, to});
      }
    for (const int node : step_.record_)
      if (step_.steps_.owner(node) == pass_) results_.push_back({node, {record, step_.place_[at(node)]}});
  }
  /// Read from the record: an earlier pass stored it.
  bool is_recorded(std::size_t i) const { return step_.place_[i] >= 0 && step_.steps_.owner(static_cast<int>(i)) < pass_; }
  bool is_input(std::size_t i) const {
    return step_.levels_[i] != Step::Level::state || is_recorded(i) || nodes_[i].operation == Operation::q ||
           nodes_[i].operation == Operation::p;
  }
  template <class F>
  void each_operand(std::size_t i, F&& f) const {
    const auto& n = nodes_[i];
    if (unary(n.operation) || binary(n.operation)) f(at(n.a));
    if (binary(n.operation)) f(at(n.b));
  }
  void find_needed() {
    needed_.assign(nodes_.size(), 0);
    uses_.assign(nodes_.size(), 0);
    for (const Result& one : results_) needed_[at(one.node)] = 1, uses_[at(one.node)] += 2;  // it is needed by itself
    for (std::size_t i = nodes_.size(); i-- > 0;)
      if (needed_[i] && !is_input(i)) each_operand(i, [&](std::size_t operand) { needed_[operand] = 1, ++uses_[operand]; });
  }
  /// A number for each expression that depends on what it computes alone, up to its sign: not on the order in which the compiler
  /// evaluated the arguments of functions while it was recorded, nor on whether a − b or b − a was recorded first.
  std::vector<std::uint64_t> digests() const {
    std::vector<std::uint64_t> all(nodes_.size());
    const auto mix = [](std::uint64_t h, std::uint64_t x) { return ((h ^ x) * 1099511628211u) ^ (h >> 29); };
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto& n = nodes_[i];
      const auto of = [&](int k) { return all[at(k)]; };
      const Operation kind = n.operation == Operation::difference ? Operation::sum : n.operation;
      std::uint64_t h = mix(14695981039346656037u, static_cast<std::uint64_t>(kind));
      if (kind == Operation::constant) h = mix(h, std::bit_cast<std::uint64_t>(std::abs(n.value)));
      if (kind == Operation::q || kind == Operation::p)
        for (const char c : (kind == Operation::q ? step_.in_->numbers : step_.in_->constants)[at(n.a)])
          h = mix(h, static_cast<unsigned char>(c));
      if (kind == Operation::quotient) h = mix(mix(h, of(n.a)), of(n.b));
      if (kind == Operation::sum || kind == Operation::product)
        h = mix(mix(h, std::min(of(n.a), of(n.b))), std::max(of(n.a), of(n.b)));
      all[i] = kind == Operation::negative ? of(n.a) : h;
    }
    return all;
  }
  /// Products that are used once become part of a multiply-add; of two, the one that is known later.
  void choose_fused() {
    const std::vector<std::uint64_t> digest = digests();
    fused_.assign(nodes_.size(), 0), factor_.assign(nodes_.size(), 0);
    std::vector<int> delay(nodes_.size(), 0);  // in cycles
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!needed_[i] || is_input(i)) continue;
      const Operation operation = nodes_[i].operation;
      each_operand(i, [&](std::size_t operand) { delay[i] = std::max(delay[i], delay[operand]); });
      delay[i] += operation == Operation::quotient ? 13 : binary(operation) ? 4 : 0;
      if (!target_.fused || (operation != Operation::sum && operation != Operation::difference)) continue;
      const std::size_t left = at(nodes_[i].a), right = at(nodes_[i].b);
      const auto product = [&](std::size_t k) {
        return nodes_[k].operation == Operation::product && uses_[k] == 1 && !is_input(k);
      };
      const bool first = product(left), second = product(right) && left != right;
      if (!first && !second) continue;
      const bool left_last = delay[left] != delay[right] ? delay[left] > delay[right] : digest[left] > digest[right];
      factor_[i] = first && (!second || left_last) ? 1 : 2;
      fused_[factor_[i] == 1 ? left : right] = 1;
    }
  }

  /// Which register hands on a number; −1: none.
  int register_of(Slot slot, bool stored) const {
    if (!(stored ? how_.to_registers : how_.in_registers)) return -1;
    const bool angular = step_.passes() == 3 && pass_ == 0;  // velocities hand on ω alone
    if (slot.array == (stored ? motion_to : motion_in)) return angular ? slot.index - 3 : slot.index;
    if (slot.array != (stored ? sum_to : sum_in) || slot.index >= 27) return -1;
    const int number = slot.index < 15 ? slot.index + 12 : slot.index - 15;  // J, D, A, B
    return number < handed_sums(target_) ? number : -1;
  }
  /// How many numbers of a sum stay in registers; the others of them are left for the operations.
  static int handed_sums(const machine::Target& target) { return target.registers / 2 - 1; }
  Place place(Slot slot) {
    if (const int number = register_of(slot, false); number >= 0) return {Place::registers, false, number};
    if (base_[at(slot.array)] < 0) {
      base_[at(slot.array)] = static_cast<int>(out_.bases.size());
      out_.bases.push_back(base_of(slot.array));
    }
    const bool shared = slot.array == constants;
    return {static_cast<std::int8_t>(base_[at(slot.array)]), shared, (shared ? target_.number : target_.vector()) * slot.index};
  }
  int input(std::size_t i) {
    const auto& n = nodes_[i];
    Place home;
    if (step_.levels_[i] == Step::Level::number) {
      const double value = n.operation == Operation::constant ? n.value : -nodes_[at(n.a)].value;
      home = {Place::pool, target_.lanes == 1 || target_.avx512,
              static_cast<int>(out_.pool.size()) * machine::pool_stride(target_)};
      out_.pool.push_back(value);
    } else if (step_.levels_[i] == Step::Level::link) {
      home = place({constants, step_.constant_slot_[i]});
    } else if (is_recorded(i)) {
      home = place({record, step_.place_[i]});
    } else if (n.operation == Operation::p) {
      home = place(step_.in_->constants[at(n.a)] == "mass" ? Slot{record, 0} : Slot{armature, 0});
    } else {
      home = place(slot_of(step_.in_->numbers[at(n.a)], false));
    }
    return add({machine::Operation::load, -1, -1, -1, home});
  }
  int add(const machine::Value& value) {
    out_.values.push_back(value);
    return static_cast<int>(out_.values.size()) - 1;
  }
  /// The value of an expression, after those that it needs.
  int visit(std::size_t i) {
    if (value_.empty()) value_.assign(nodes_.size(), -1);
    if (value_[i] >= 0) return value_[i];
    if (is_input(i)) return value_[i] = input(i);
    const auto& n = nodes_[i];
    machine::Value x{};
    if (n.operation == Operation::negative) {
      x = {machine::Operation::negate, visit(at(n.a))};
    } else if (factor_[i] != 0) {
      const auto& product = nodes_[at(factor_[i] == 1 ? n.a : n.b)];
      const int left = visit(at(product.a)), right = visit(at(product.b)), rest = visit(at(factor_[i] == 1 ? n.b : n.a));
      using enum machine::Operation;
      x = {n.operation == Operation::sum ? multiply_add
           : factor_[i] == 1             ? multiply_subtract
                                         : subtract_product,
           left, right, rest};
    } else {
      const int left = visit(at(n.a)), right = visit(at(n.b));
      using enum machine::Operation;
      x = {n.operation == Operation::sum          ? machine::Operation::add
           : n.operation == Operation::difference ? subtract
           : n.operation == Operation::product    ? multiply
                                                  : divide,
           left, right};
    }
    value_[i] = add(x);
    out_.order.push_back(value_[i]);
    return value_[i];
  }

  /// Whether a place may be that of a number which the pass reads.
  bool overwrites(const Place& to) const { return to.base >= 0 && (to.base == base_[sum_to] || to.base == base_[motion_to]); }
  bool is_zero_number(int node) const { return nodes_[at(node)].operation == Operation::constant && nodes_[at(node)].value == 0; }
  /// Each number is stored as soon as it is known, and nothing in the same memory is still to be read.
  void add_stores() {
    std::vector<machine::Store> stores;
    for (const Result& one : results_) {
      const int number = register_of(one.to, true);
      if (number < 0 && one.to.array == motion_to && !how_.to_memory) continue;
      const Place to = number < 0 || (one.to.array == motion_to ? how_.to_memory : how_.adds) ? place(one.to) : Place{};
      int value = visit(at(one.node));
      if (how_.adds && one.to.array == sum_to) {
        const bool nothing = is_zero_number(one.node);
        if (nothing && number < 0) continue;
        const int before = add({machine::Operation::load, -1, -1, -1, to});
        if (!nothing) {
          const auto known = std::ranges::find(out_.order, value);
          value = add({machine::Operation::add, value, before});
          out_.order.insert(known == out_.order.end() ? known : known + 1, value);
        } else {
          value = before;
        }
      }
      if (number >= 0) {
        if (out_.outputs.size() <= at(number)) out_.outputs.resize(at(number) + 1, -1);
        out_.outputs[at(number)] = value;
        if (one.to.array == sum_to || !how_.to_memory) continue;
      }
      stores.push_back({value, to, 0});
    }
    const int end = static_cast<int>(out_.order.size());
    std::vector<int> known(out_.values.size(), 0);
    std::array<int, std::size(sum_numbers)> last_read{};  // of the numbers of children, or of the parent
    const auto reads = [&](int v, int when) {
      if (v < 0 || out_.values[at(v)].operation != machine::Operation::load) return;
      const Place& home = out_.values[at(v)].home;
      for (const Array array : {sum_in, motion_in})
        if (home.base == base_[at(array)]) last_read[at(home.offset / target_.vector())] = when;
    };
    for (int t = 0; t < end; ++t) {
      const int v = out_.order[at(t)];
      known[at(v)] = t + 1;
      reads(out_.values[at(v)].a, t + 1), reads(out_.values[at(v)].b, t + 1), reads(out_.values[at(v)].c, t + 1);
    }
    for (const int v : out_.outputs) reads(v, end);
    for (machine::Store& one : stores) {  // copies
      reads(one.value, end);
      const machine::Value& value = out_.values[at(one.value)];
      const bool child = value.home.base >= 0 && (value.home.base == base_[sum_in] || value.home.base == base_[motion_in]);
      const bool same = overwrites(one.to) && value.home.offset == one.to.offset;
      one.read_early = value.operation == machine::Operation::load && child && !same;
    }
    for (machine::Store& one : stores) {
      one.due = out_.values[at(one.value)].operation == machine::Operation::load ? end : known[at(one.value)];
      if (overwrites(one.to) && !(how_.adds && one.to.base == base_[sum_to]))
        one.due = std::max(one.due, last_read[at(one.to.offset / target_.vector())]);
    }
    std::ranges::stable_sort(stores, {}, &machine::Store::due);
    out_.stores = std::move(stores);
  }

  const Step& step_;
  const std::vector<Expressions::Node>& nodes_;
  std::size_t pass_;
  const Handing& how_;
  const machine::Target& target_;
  machine::Function out_;
  std::vector<Result> results_;
  std::vector<char> needed_, fused_, factor_;
  std::vector<int> uses_, value_;
  std::array<int, arrays> base_ = [] {
    std::array<int, arrays> none;
    none.fill(-1);
    return none;
  }();
};

machine::Function Step::function(std::size_t pass, const Handing& how, const machine::Target& target) const {
  return Lowering(*this, pass, how, target).run();
}

}  // namespace momentree::derive
