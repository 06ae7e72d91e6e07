// A pass of a recorded step as a function for machine code.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include <momentree/derive/graph_lowering.hpp>
#include <momentree/derive/step.hpp>
#include <momentree/joint/pass_data.hpp>

namespace momentree::derive {

namespace {

using machine::Place;

// The numbers of an Inboard and of a Motion by name, in the order of their memory.
constexpr std::string_view sum_numbers[] = {"M.A.xx", "M.A.yy", "M.A.zz", "M.A.xy", "M.A.xz", "M.A.yz", "M.B.xx", "M.B.xy",
                                            "M.B.xz", "M.B.yx", "M.B.yy", "M.B.yz", "M.B.zx", "M.B.zy", "M.B.zz", "M.J.xx",
                                            "M.J.yy", "M.J.zz", "M.J.xy", "M.J.xz", "M.J.yz", "D.l.x",  "D.l.y",  "D.l.z",
                                            "D.h.x",  "D.h.y",  "D.h.z",  "mc.x",   "mc.y",   "mc.z"};
constexpr std::string_view motion_numbers[] = {"v.x", "v.y", "v.z", "w.x", "w.y", "w.z"};
constexpr std::string_view output_numbers[] = {"velocity.v.x", "velocity.v.y", "velocity.v.z", "velocity.w.x", "velocity.w.y",
                                               "velocity.w.z", "gravity.x",    "gravity.y",    "gravity.z"};
constexpr std::string_view moment_numbers[] = {"x", "y", "z"};
static_assert(numbers_of_sum(Passes::momenta) == std::size(sum_numbers) && sizeof(BodyBias<double>) == 12 * 8 &&
              sizeof(BodySweep<double>) == 12 * 8 && numbers_of_motion(Passes::momenta) == std::size(output_numbers));
static_assert(offsetof(Inboard<double>, M.A.yz) == 5 * 8 && offsetof(Inboard<double>, M.B.yx) == 9 * 8 &&
              offsetof(Inboard<double>, M.J.xx) == 15 * 8 && offsetof(Inboard<double>, D.h.z) == 26 * 8 &&
              offsetof(Inboard<double>, mc.z) == 29 * 8 && offsetof(Motion<double>, w.z) == 5 * 8 &&
              offsetof(Outboard<double>, gravity.z) == 8 * 8);

}  // namespace

class Step::Lowering : GraphLowering {
 public:
  Lowering(const Step& step, std::size_t pass, const Handing& how, const machine::Target& target)
      : GraphLowering(step.in_->expressions.nodes(), target), step_(step), pass_(pass), how_(how) {}

  machine::Function run() {
    find_stores();
    for (const Result& one : results_) need(one.node);
    choose();
    for (int i : step_.steps_.functions[pass_].first) {
      while (nodes_[at(i)].operation == Operation::negative) i = nodes_[at(i)].a;
      if (is_needed(at(i)) && !is_fused(at(i))) visit(at(i));
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (is_computed(i)) visit(i);
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
    mass,
    body_sweep,
    bias,
    inboard_acceleration,
    reduced_bias_wrench,
    load,
    constants,
    arrays
  };

  machine::Base base_of(Array array) const {
    const bool keeps = keeps_results(step_.kind_);
    const auto of_bodies = [&](int place, int memory, int numbers) {
      return machine::Base{place, memory, keeps ? numbers * target_.vector() : 1};
    };
    const int own = pass_ == step_.inward() ? offsetof(StepEntry, in) : offsetof(StepEntry, to);
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
      MOMENTREE_BASE(armature, dof, armature)
#undef MOMENTREE_BASE
      case sum_in: return of_bodies(offsetof(StepEntry, in), offsetof(StepArrays, sums), numbers_of_sum(step_.kind_));
      case sum_to: return of_bodies(offsetof(StepEntry, to), offsetof(StepArrays, sums), numbers_of_sum(step_.kind_));
      case motion_in: return of_bodies(offsetof(StepEntry, in), offsetof(StepArrays, motions), numbers_of_motion(step_.kind_));
      case motion_to: return of_bodies(offsetof(StepEntry, to), offsetof(StepArrays, motions), numbers_of_motion(step_.kind_));
      case body_sweep: return of_bodies(own, offsetof(StepArrays, body_sweeps), 12);
      case bias: return of_bodies(own, offsetof(StepArrays, biases), 12);
      case inboard_acceleration: return of_bodies(own, offsetof(StepArrays, inboard_accelerations), 6);
      case reduced_bias_wrench: return of_bodies(own, offsetof(StepArrays, reduced_bias_wrenches), 6);
      case load: return of_bodies(own, offsetof(StepArrays, loads), 6);
      case record: return {offsetof(StepEntry, record), offsetof(StepArrays, records), keeps ? target_.vector() : 1};
      case mass: return {own, offsetof(StepArrays, masses), target_.number};
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
    if (indexed("r[")) return {record, index()};
    if (indexed("s[")) return {sum_in, index()};
    if (indexed("t[")) return {sum_to, index()};
    if (indexed("i[")) return {motion_in, index()};
    if (indexed("o[")) return {motion_to, index()};
    if (indexed("m[")) return {body_sweep, index()};
    if (indexed("b[")) return {bias, index()};
    if (indexed("x[")) return {inboard_acceleration, index()};
    if (indexed("l[")) return {load, index()};
    if (indexed("w[")) return {reduced_bias_wrench, index()};
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
  bool is_input(std::size_t i) const override {
    return step_.levels_[i] != Step::Level::state || is_recorded(i) || nodes_[i].operation == Operation::q ||
           nodes_[i].operation == Operation::p;
  }
  std::uint64_t digest_of(std::size_t i, std::uint64_t h) const override {
    for (const char c : (nodes_[i].operation == Operation::q ? step_.in_->numbers : step_.in_->constants)[at(nodes_[i].a)])
      h = mix(h, static_cast<unsigned char>(c));
    return h;
  }

  /// Which register hands on a number; −1: none.
  int register_of(Slot slot, bool stored) const {
    if (!(stored ? how_.to_registers : how_.in_registers)) return -1;
    const bool angular = step_.kind_ == Passes::stage_velocities && pass_ == 0;  // velocities hand on ω alone
    if (slot.array == (stored ? motion_to : motion_in)) return angular ? slot.index - 3 : slot.index;
    if (slot.array != (stored ? sum_to : sum_in) || slot.index >= 27) return -1;
    const int number = numbers_of_sum(step_.kind_) == 6 ? slot.index
                       : slot.index < 15                ? slot.index + 12
                                                        : slot.index - 15;  // J, D, A, B
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
    const bool shared = slot.array == constants || slot.array == mass;
    return {static_cast<std::int8_t>(base_[at(slot.array)]), shared, (shared ? target_.number : target_.vector()) * slot.index};
  }
  Place place_of(std::size_t i) override {
    const auto& n = nodes_[i];
    if (step_.levels_[i] == Step::Level::number)
      return pool(n.operation == Operation::constant ? n.value : -nodes_[at(n.a)].value);
    if (step_.levels_[i] == Step::Level::link) return place({constants, step_.constant_slot_[i]});
    if (is_recorded(i)) return place({record, step_.place_[i]});
    if (n.operation == Operation::p) {
      if (step_.in_->constants[at(n.a)] != "mass") return place(Slot{armature, 0});
      return place(keeps_results(step_.kind_) ? Slot{mass, 0} : Slot{record, 0});
    }
    return place(slot_of(step_.in_->numbers[at(n.a)], false));
  }

  /// What places that may be the same memory have in common. Contributions of children, and what the parent hands on, may be
  /// where the body writes its own; added to those of others, they are not.
  std::pair<int, int> memory_of(const Place& place) const {
    int base = place.base;
    if (base >= 0 && base == base_[sum_to] && !how_.adds) base = base_[sum_in];
    if (base >= 0 && base == base_[motion_to]) base = base_[motion_in];
    return {base < 0 ? -place.base - 2 : base, place.offset};
  }
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
        const int before = append({machine::Operation::load, -1, -1, -1, to});
        if (!nothing) {
          const auto known = std::ranges::find(out_.order, value);
          value = append({machine::Operation::add, value, before});
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
    std::map<std::pair<int, int>, int> last_read;
    const auto reads = [&](int v, int when) {
      if (v < 0 || out_.values[at(v)].operation != machine::Operation::load) return;
      last_read[memory_of(out_.values[at(v)].home)] = when;
    };
    for (int t = 0; t < end; ++t) {
      const int v = out_.order[at(t)];
      known[at(v)] = t + 1;
      reads(out_.values[at(v)].a, t + 1), reads(out_.values[at(v)].b, t + 1), reads(out_.values[at(v)].c, t + 1);
    }
    for (const int v : out_.outputs) reads(v, end);
    std::set<std::pair<int, int>> written;
    for (const machine::Store& one : stores) reads(one.value, end), written.insert(memory_of(one.to));
    for (machine::Store& one : stores) {
      const machine::Value& value = out_.values[at(one.value)];
      const bool copy = value.operation == machine::Operation::load;
      one.read_early = copy && written.contains(memory_of(value.home)) && memory_of(value.home) != memory_of(one.to);
      one.due = copy ? end : known[at(one.value)];
      if (const auto last = last_read.find(memory_of(one.to)); last != last_read.end()) one.due = std::max(one.due, last->second);
    }
    std::ranges::stable_sort(stores, {}, &machine::Store::due);
    out_.stores = std::move(stores);
  }

  const Step& step_;
  std::size_t pass_;
  const Handing& how_;
  std::vector<Result> results_;
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
