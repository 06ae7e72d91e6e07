#pragma once
// A function without branches over named memory: what becomes machine code.
#include <cstdint>
#include <vector>

namespace momentree::machine {

/// What the machine code is for.
struct Target {
  int lanes = 1;       ///< worlds at once: 1, or as many as fill 32 bytes, or 64 with AVX-512
  int number = 8;      ///< bytes of a number: 8, or 4 in single precision
  int registers = 16;  ///< of vectors: 16, or 32 with AVX-512
  bool avx512 = false;
  bool fused = true;  ///< multiply-adds round once

  constexpr int vector() const { return lanes * number; }  ///< bytes
};

/// A number in memory. Of several worlds, each has its own number there, or all share one.
struct Place {
  /// The function's constants; its own memory, which begins with that for calls; and registers that hold a number when it is
  /// called, `offset` being which one.
  static constexpr std::int8_t pool = 32, frame = 33, registers = 34;

  std::int8_t base = -1;  ///< number of the Base, or one of these
  bool shared = false;
  std::int32_t offset = 0;  ///< in bytes
  friend bool operator==(const Place&, const Place&) = default;
};

/// Where a function finds an address: a pointer in its first argument at `entry`; or, if `memory` ≥ 0, the pointer in its second
/// argument at `memory`, plus the 32 bits of the first one at `entry` times `times`.
struct Base {
  int entry = 0, memory = -1, times = 1;
};

/// `maximum`: a if a > b, else b. `multiply_add`: a b + c, `multiply_subtract`: a b − c, `subtract_product`: c − a b.
enum class Operation : std::uint8_t {
  load,
  add,
  subtract,
  multiply,
  divide,
  maximum,
  multiply_add,
  multiply_subtract,
  subtract_product,
  negate
};

struct Value {
  Operation operation = Operation::load;
  int a = -1, b = -1, c = -1;  ///< operands: numbers of other values
  Place home{};                ///< of a load
};

struct Store {
  int value = 0;
  Place to;
  int due = 0;              ///< after so many operations
  bool read_early = false;  ///< its value, a load, is read before any store that is due at the end
};

/// Calls a C++ function, void(const void* entry, double* memory, int index), before operation number `time`; at least one
/// operation follows. Its address is at `function` in what the pointer at `context` of the first argument points to. Stores into
/// the function's own memory give it its arguments; values that it leaves there are loaded after the call alone.
struct Call {
  int time = 0;
  int context = 0, function = 0;
  int memory = 0;  ///< bytes: where the memory that it gets begins
  int index = 0;
};

struct Function {
  std::vector<Value> values;
  std::vector<int> order;     ///< the values other than loads, in the order of the operations
  std::vector<Store> stores;  ///< in the order in which they are due
  std::vector<double> pool;   ///< constants
  std::vector<Base> bases;
  std::vector<int> outputs{};  ///< values that registers 0, 1, … hold when it returns
  std::vector<Call> calls{};   ///< by time; for one world in doubles
  int memory = 0;              ///< numbers of own memory for calls
};

/// One instruction. `direct`: an operand in a register; else in memory at `place`.
enum class Code : std::uint8_t {
  load,
  spread,
  store,
  move,
  add,
  subtract,
  multiply,
  divide,
  maximum,
  flip_sign,
  fused_132,
  fused_213,
  fused_231,
  call
};
struct Instruction {
  Code code = Code::load;
  std::uint8_t variant = 0;  ///< of fused_…: 0: a b + c, 1: a b − c, 2: c − a b
  std::uint8_t to = 0, from = 0;
  std::int8_t other = -1;  ///< the register of the last operand; −1: it is in memory
  Place place{};           ///< of a call: `offset` is its number
};

/// A function with registers.
struct Allocated {
  std::vector<Instruction> code;
  int frame = 0;  ///< numbers of own memory
};
[[nodiscard]] Allocated allocate(const Function& function, const Target& target);

/// Bytes of one constant in the pool: with AVX2 they are stored once per lane, because only AVX-512 spreads operands.
constexpr int pool_stride(const Target& target) { return target.lanes > 1 && !target.avx512 ? target.vector() : target.number; }

}  // namespace momentree::machine
