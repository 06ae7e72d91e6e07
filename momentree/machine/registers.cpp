// Registers for a function without branches: what is needed last goes back to memory first.
#include <algorithm>
#include <array>
#include <limits>

#include <momentree/base/check.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::machine {

namespace {

constexpr int never = std::numeric_limits<int>::max() / 2;

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Allocator {
 public:
  Allocator(const Function& function, const Target& target) : f_(function), target_(target) {
    const std::size_t n = f_.values.size();
    first_use_.assign(n + 1, 0);
    register_.assign(n, -1), slot_.assign(n, -1), home_.resize(n), has_home_.assign(n, 0);
    each_use([&](int v, int) { ++first_use_[at(v) + 1]; });
    for (std::size_t i = 0; i < n; ++i) first_use_[i + 1] += first_use_[i];
    uses_.resize(at(first_use_[n]));
    next_use_.assign(first_use_.begin(), first_use_.end() - 1);
    std::vector<int> fill = next_use_;
    each_use([&](int v, int t) { uses_[at(fill[at(v)]++)] = t; });
    held_.fill(-1);
    out_.frame = f_.memory;
    for (std::size_t i = 0; i < n; ++i) {
      if (f_.values[i].operation != Operation::load) continue;
      const Place& home = f_.values[i].home;
      if (home.base == Place::registers)
        held_[at(home.offset)] = static_cast<int>(i), register_[i] = home.offset;
      else
        home_[i] = home, has_home_[i] = 1;
    }
  }

  Allocated run() {
    const int end = static_cast<int>(f_.order.size());
    store_what_is_due(-1);
    for (int t = 0; t < end; ++t) {
      for (const int slot : freed_) free_slots_.push_back(slot);
      freed_.clear();
      for (; called_ < f_.calls.size() && f_.calls[called_].time <= t; ++called_) call();
      const int v = f_.order[at(t)];
      const int to = operation(f_.values[at(v)], t);
      held_[at(to)] = v, register_[at(v)] = to;
      store_what_is_due(t);
      if (register_[at(v)] >= 0 && next(v) >= never) held_[at(to)] = register_[at(v)] = -1;
    }
    place_outputs(end);
    return std::move(out_);
  }

 private:
  /// Calls f(value, time) for every use of a value, in the order of time: by an operation, or by a store after it.
  template <class F>
  void each_use(F&& f) const {
    std::size_t k = 0;
    const int end = static_cast<int>(f_.order.size());
    for (int t = -1; t <= end; ++t) {
      if (t >= 0 && t < end) {
        const Value& x = f_.values[at(f_.order[at(t)])];
        for (const int v : {x.a, x.b, x.c})
          if (v >= 0) f(v, t);
      }
      for (; k < f_.stores.size() && (f_.stores[k].due <= t + 1 || t == end); ++k) f(f_.stores[k].value, t);
    }
    for (const int v : f_.outputs) f(v, end);
  }

  int next(int v) const { return next_use_[at(v)] < first_use_[at(v) + 1] ? uses_[at(next_use_[at(v)])] : never; }
  /// The first use after time t.
  int after(int v, int t) const {
    int use = next_use_[at(v)];
    while (use < first_use_[at(v) + 1] && uses_[at(use)] <= t) ++use;
    return use < first_use_[at(v) + 1] ? uses_[at(use)] : never;
  }
  /// Whether the next use is the last one.
  bool dies(int v) const { return next_use_[at(v)] + 1 >= first_use_[at(v) + 1]; }
  bool in_register(int v) const { return register_[at(v)] >= 0; }
  /// Whether an instruction can read it from memory: AVX2 has no operands that all lanes share.
  bool readable(int v) const { return !home_[at(v)].shared || target_.lanes == 1 || target_.avx512; }

  void emit(Code code, int to, int from, int other, const Place& place = {}, int variant = 0) {
    out_.code.push_back({code, static_cast<std::uint8_t>(variant), static_cast<std::uint8_t>(to), static_cast<std::uint8_t>(from),
                         static_cast<std::int8_t>(other), place});
  }
  /// An instruction whose last operand is v, wherever it is.
  void emit_with(Code code, int to, int from, int v, int variant = 0) {
    emit(code, to, from, register_[at(v)], in_register(v) ? Place{} : home_[at(v)], variant);
  }

  /// A register other than the pinned ones: a free one, or that whose value is used last; values in memory count twice.
  int take(unsigned pinned, int t) {
    int best = -1;
    long furthest = -1;
    for (int r = 0; r < target_.registers; ++r) {
      if ((pinned >> r & 1u) != 0) continue;
      const int v = held_[at(r)];
      if (v < 0) return r;
      const int use = next(v);
      const long distance = use >= never ? never : static_cast<long>(use - t) * (has_home_[at(v)] ? 2 : 1);
      if (distance > furthest) furthest = distance, best = r;
    }
    MT_REQUIRE(best >= 0, "some register is not pinned");
    free(best);
    return best;
  }
  /// Leaves the value of a register in memory if it is used again.
  void free(int r) {
    const int v = held_[at(r)];
    if (!has_home_[at(v)] && next(v) < never) {
      int slot = out_.frame;
      if (free_slots_.empty())
        ++out_.frame;
      else
        slot = free_slots_.back(), free_slots_.pop_back();
      home_[at(v)] = {Place::frame, false, slot * target_.vector()};
      has_home_[at(v)] = 1, slot_[at(v)] = slot;
      emit(Code::store, 0, r, -1, home_[at(v)]);
    }
    register_[at(v)] = held_[at(r)] = -1;
  }
  /// A function of C++ keeps no registers.
  void call() {
    for (int r = 0; r < target_.registers; ++r)
      if (held_[at(r)] >= 0) free(r);
    emit(Code::call, 0, 0, -1, {Place::frame, false, static_cast<std::int32_t>(called_)});
  }
  void load_into(int r, int v) {
    emit(home_[at(v)].shared && target_.lanes > 1 ? Code::spread : Code::load, r, 0, -1, home_[at(v)]);
  }
  int load(int v, unsigned pinned, int t) {
    const int r = take(pinned, t);
    load_into(r, v);
    held_[at(r)] = v;
    return register_[at(v)] = r;
  }
  void used(int v) {
    ++next_use_[at(v)];
    if (next(v) < never) return;
    if (in_register(v)) held_[at(register_[at(v)])] = -1, register_[at(v)] = -1;
    if (slot_[at(v)] >= 0) freed_.push_back(slot_[at(v)]), slot_[at(v)] = -1;
  }

  /// Reads a number that may be overwritten from here on.
  void read_early(int v, int t) {
    if (!in_register(v)) load(v, 0, t);
    if (slot_[at(v)] < 0) has_home_[at(v)] = 0;
  }
  void store_what_is_due(int t) {
    if (t == static_cast<int>(f_.order.size()) - 1) {
      for (std::size_t k = stored_; k < f_.stores.size(); ++k)
        if (f_.stores[k].read_early) read_early(f_.stores[k].value, t);
      for (const int v : f_.outputs)
        if (f_.values[at(v)].operation == Operation::load && f_.values[at(v)].home.base != Place::pool) read_early(v, t);
    }
    for (; stored_ < f_.stores.size() && f_.stores[stored_].due <= t + 1; ++stored_) {
      const Store& one = f_.stores[stored_];
      const int r = in_register(one.value) ? register_[at(one.value)] : load(one.value, 0, t);
      emit(Code::store, 0, r, -1, one.to);
      if (!has_home_[at(one.value)] && one.to.base != Place::frame)  // a call may change what it was given
        home_[at(one.value)] = one.to, has_home_[at(one.value)] = 1;
      used(one.value);
    }
  }

  /// Moves the outputs to their registers.
  void place_outputs(int end) {
    std::vector<int> in(f_.outputs.size());
    unsigned pinned = 0;
    for (std::size_t k = 0; k < in.size(); ++k) {
      const int v = f_.outputs[k];
      in[k] = in_register(v) ? register_[at(v)] : load(v, pinned, end);
      pinned |= 1u << in[k];
    }
    MT_REQUIRE(static_cast<int>(in.size()) < target_.registers, "a register is left for moves");
    for (int left = static_cast<int>(in.size()); left > 0;) {
      left = 0;
      bool moved = false;
      for (int k = 0; k < static_cast<int>(in.size()); ++k) {
        if (in[at(k)] == k) continue;
        ++left;
        if (std::ranges::find(in, k) != in.end()) continue;  // another one is still there
        emit(Code::move, k, 0, in[at(k)]);
        in[at(k)] = k, moved = true;
      }
      if (left == 0 || moved) continue;
      const int first = static_cast<int>(std::ranges::find_if(in, [k = 0](int r) mutable { return r != k++; }) - in.begin());
      const int apart = static_cast<int>(in.size()), from = in[at(first)];  // all that are left are in cycles
      emit(Code::move, apart, 0, from);
      std::ranges::replace(in, from, apart);
    }
  }

  /// Emits an operation; returns the register of its result.
  int operation(const Value& x, int t) {
    unsigned pinned = 0;
    for (const int v : {x.a, x.b, x.c})
      if (v >= 0 && in_register(v)) pinned |= 1u << register_[at(v)];
    for (const int v : {x.a, x.b, x.c}) {
      if (v < 0 || in_register(v)) continue;
      const int again = after(v, t) - t;  // what is soon used again is worth a register
      if (!readable(v) || again < (f_.values[at(v)].operation == Operation::load ? target_.registers / 2 : 40))
        pinned |= 1u << load(v, pinned, t);
    }
    if (x.operation == Operation::negate) return negate(x.a, pinned, t);
    return x.operation < Operation::multiply_add ? two_operands(x, pinned, t) : fused(x, pinned, t);
  }

  int negate(int a, unsigned pinned, int t) {
    const int r = in_register(a) ? register_[at(a)] : load(a, pinned, t);
    const bool last = dies(a);
    used(a);
    const int to = last ? r : take(pinned | 1u << r, t);
    const int sign = static_cast<int>(f_.pool.size()) * pool_stride(target_);
    emit(Code::flip_sign, to, r, -1, {Place::pool, target_.lanes > 1 && target_.avx512, sign});
    return to;
  }

  int two_operands(const Value& x, unsigned pinned, int t) {
    int a = x.a, b = x.b;
    const bool commutes = x.operation == Operation::add || x.operation == Operation::multiply;
    if (commutes && !in_register(a) && (in_register(b) || after(b, t) < after(a, t))) std::swap(a, b);
    if (!in_register(a)) load(a, pinned, t);
    pinned |= 1u << register_[at(a)];
    constexpr Code codes[] = {Code::load, Code::add, Code::subtract, Code::multiply, Code::divide, Code::maximum};
    const int ra = register_[at(a)], rb = register_[at(b)];
    const Place place = rb < 0 ? home_[at(b)] : Place{};
    used(a), used(b);
    const int to = held_[at(ra)] < 0 ? ra : rb >= 0 && held_[at(rb)] < 0 ? rb : take(pinned, t);
    emit(codes[static_cast<std::size_t>(x.operation)], to, ra, rb, place);
    return to;
  }

  int fused(const Value& x, unsigned pinned, int t) {
    int a = x.a, b = x.b;
    const int c = x.c, variant = static_cast<int>(x.operation) - static_cast<int>(Operation::multiply_add);
    leave_one_in_memory({a, b, c}, pinned, t);
    const auto in_memory = [&](int v) { return !in_register(v); };
    if (in_memory(a)) std::swap(a, b);
    const int memory = in_memory(b) ? b : in_memory(c) ? c : -1;
    const auto replaced = [&](int v, int one, int other) { return !in_memory(v) && dies(v) && v != one && v != other; };
    const bool over_a = replaced(a, b, c), over_b = replaced(b, a, c), over_c = replaced(c, a, b);
    int to = -1;
    if (over_c) {
      to = register_[at(c)], emit_with(Code::fused_231, to, register_[at(a)], b, variant);
    } else if (over_a && memory == b) {
      to = register_[at(a)], emit_with(Code::fused_132, to, register_[at(c)], b, variant);
    } else if (over_a || over_b) {
      if (!over_a) std::swap(a, b);
      to = register_[at(a)], emit_with(Code::fused_213, to, register_[at(b)], c, variant);
    } else {
      to = take(pinned, t);
      if (memory == c)
        load_into(to, c);
      else
        emit(Code::move, to, 0, register_[at(c)]);
      emit_with(Code::fused_231, to, register_[at(a)], b, variant);
    }
    used(a), used(b), used(c);
    return to;
  }
  /// Loads operands, those first that are soon used again, until at most one is in memory.
  void leave_one_in_memory(const std::array<int, 3>& operands, unsigned& pinned, int t) {
    for (;;) {
      int count = 0, soonest = -1;
      for (const int v : operands) {
        if (in_register(v)) continue;
        ++count;
        if (soonest < 0 || after(v, t) < after(soonest, t)) soonest = v;
      }
      if (count <= 1) return;
      pinned |= 1u << load(soonest, pinned, t);
    }
  }

  const Function& f_;
  const Target& target_;
  Allocated out_;
  std::vector<int> first_use_, uses_, next_use_;  // of each value: its uses by time, and the next one
  std::vector<int> register_, slot_;
  std::vector<Place> home_;
  std::vector<char> has_home_;
  std::array<int, 32> held_;  // by register: the value in it
  std::vector<int> free_slots_, freed_;
  std::size_t stored_ = 0, called_ = 0;
};

}  // namespace

Allocated allocate(const Function& function, const Target& target) { return Allocator(function, target).run(); }

}  // namespace momentree::machine
