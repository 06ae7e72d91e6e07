// VEX and EVEX encodings: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, chapter 2.
#include <momentree/machine/x86.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <utility>

#include <momentree/base/check.hpp>

namespace momentree::machine {

namespace {

constexpr int rsp = 4, rsi = 6, rdi = 7;
// Registers for bases: the first ones belong to the callee, the others have to be restored.
constexpr std::array<int, 13> base_registers{0, 1, 2, 8, 9, 10, 11, 3, 5, 12, 13, 14, 15};
constexpr std::size_t free_registers = 7;

class Encoder {
 public:
  Encoder(const Function& function, const Allocated& allocated, const Target& target)
      : f_(function), allocated_(allocated), target_(target) {}

  Bytes run() {
    MT_REQUIRE(f_.bases.size() <= base_registers.size(), "there is a register for each base");
    pool();
    const std::size_t entry = out_.size();
    const std::size_t pushed = f_.bases.size() > free_registers ? f_.bases.size() - free_registers : 0;
    int frame = allocated_.frame * target_.vector();
    if (!f_.calls.empty() && (8 * (pushed + 1) + static_cast<std::size_t>(frame)) % 16 != 0) frame += 8;  // calls are aligned
    for (std::size_t i = free_registers; i < f_.bases.size(); ++i) push(base_registers[i]);
    if (frame > 0) bytes({0x48, 0x81, 0xEC}), number(frame);  // sub rsp, frame
    load_bases();
    for (const Instruction& one : allocated_.code)
      one.code == Code::call ? call(f_.calls[static_cast<std::size_t>(one.place.offset)]) : vector_instruction(one);
    if (frame > 0) bytes({0x48, 0x81, 0xC4}), number(frame);  // add rsp, frame
    for (std::size_t i = f_.bases.size(); i-- > free_registers;) pop(base_registers[i]);
    byte(0xC3);  // ret
    return {std::move(out_), entry};
  }

 private:
  void byte(int x) { out_.push_back(static_cast<std::uint8_t>(x)); }
  void bytes(std::initializer_list<int> all) {
    for (const int x : all) byte(x);
  }
  void number(std::int32_t x) {
    for (int i = 0; i < 4; ++i) byte(x >> 8 * i & 0xFF);
  }

  /// The constants, and −0.0, whose bit changes signs.
  void pool() {
    const bool repeated = target_.lanes > 1 && !target_.avx512;
    const auto put = [&](double x, int times) {
      const auto bits = std::bit_cast<std::uint64_t>(x);
      const auto single = std::bit_cast<std::int32_t>(static_cast<float>(x));
      for (int i = 0; i < times; ++i) {
        number(is_single() ? single : static_cast<std::int32_t>(bits));
        if (!is_single()) number(static_cast<std::int32_t>(bits >> 32));
      }
    };
    for (const double x : f_.pool) put(x, repeated ? target_.lanes : 1);
    put(-0.0, repeated ? target_.lanes : 16 / target_.number);  // the instruction for one world reads 16 bytes
    while (out_.size() % 16 != 0) byte(0);
  }

  void push(int r) {
    if (r > 7) byte(0x41);
    byte(0x50 | (r & 7));
  }
  void pop(int r) {
    if (r > 7) byte(0x41);
    byte(0x58 | (r & 7));
  }
  /// Instruction `opcode` r, [from + displacement].
  void integer(int opcode, int r, int from, int displacement) {
    const bool is_short = displacement < 128;
    bytes({0x48 | r >> 3 << 2, opcode, (is_short ? 0x40 : 0x80) | (r & 7) << 3 | from});
    if (is_short)
      byte(displacement);
    else
      number(displacement);
  }
  void multiply(int r, int by) { bytes({0x48 | r >> 3 << 2 | r >> 3, 0x69, 0xC0 | (r & 7) << 3 | (r & 7)}), number(by); }
  void load_bases() {
    for (std::size_t i = 0; i < f_.bases.size(); ++i) load_base(base_registers[i], f_.bases[i]);
  }
  void call(const Call& to) {
    bytes({0x57, 0x56});                                      // push rdi, rsi
    bytes({0x48, 0x8D, 0xB4, 0x24}), number(16 + to.memory);  // lea rsi, [rsp + 16 + memory]
    byte(0xBA), number(to.index);                             // mov edx, index
    integer(0x8B, 0, rdi, to.context);                        // mov rax, [rdi + context]
    MT_REQUIRE(to.function >= 0 && to.function < 128, "few functions are called");
    bytes({0xFF, 0x50, to.function});  // call [rax + function]
    bytes({0x5E, 0x5F});               // pop rsi, rdi
    load_bases();
  }
  void load_base(int r, const Base& base) {
    if (base.memory < 0) return integer(0x8B, r, rdi, base.entry);  // mov
    integer(0x63, r, rdi, base.entry);                              // movsxd
    if (base.times != 1) multiply(r, base.times);                   // imul
    integer(0x03, r, rsi, base.memory);                             // add
  }

  static bool is_fused(Code code) { return code >= Code::fused_132 && code <= Code::fused_231; }
  bool is_single() const { return target_.number == 4; }

  void vector_instruction(const Instruction& one) {
    const bool wide = target_.lanes > 1, memory = one.other < 0;
    const int packed = is_single() ? 0 : 1;  // the prefix of instructions on whole registers
    int map = 1, prefix = wide ? packed : is_single() ? 2 : 3, opcode = 0, first = one.to, second = one.from;
    switch (one.code) {
      case Code::load: opcode = 0x10, second = 0; break;  // vmovsd, vmovupd; in single precision vmovss, vmovups, and so on
      case Code::store: opcode = 0x11, first = one.from, second = 0; break;
      case Code::spread: map = 2, prefix = 1, opcode = is_single() ? 0x18 : 0x19, second = 0; break;  // vbroadcastsd
      case Code::move: opcode = 0x28, prefix = packed, second = 0; break;                             // vmovapd
      case Code::add: opcode = 0x58; break;
      case Code::subtract: opcode = 0x5C; break;
      case Code::multiply: opcode = 0x59; break;
      case Code::divide: opcode = 0x5E; break;
      case Code::maximum: opcode = 0x5F; break;
      case Code::flip_sign: opcode = 0x57, prefix = packed; break;  // vxorpd
      case Code::fused_132:
      case Code::fused_213:
      case Code::fused_231: {  // vfmadd, vfmsub, vfnmadd
        constexpr int opcodes[] = {0x98, 0xA8, 0xB8};
        map = 2, prefix = 1;
        opcode = opcodes[static_cast<int>(one.code) - static_cast<int>(Code::fused_132)] + 2 * one.variant + (wide ? 0 : 1);
        break;
      }
      case Code::call: break;
    }
    const bool spread = memory && one.place.shared && wide && one.code != Code::spread;
    const int rm = memory ? register_of(one.place) : one.other;
    const bool evex = target_.vector() == 64 || first > 15 || second > 15 || (!memory && rm > 15) || spread;
    if (evex) {
      const int length = target_.vector() / 32;
      bytes({0x62, (first & 8 ? 0 : 0x80) | (!memory && rm & 16 ? 0 : 0x40) | (rm & 8 ? 0 : 0x20) | (first & 16 ? 0 : 0x10) | map,
             (is_single() ? 0 : 0x80) | (~second & 15) << 3 | 4 | prefix,
             length << 5 | (spread ? 0x10 : 0) | (second & 16 ? 0 : 8)});
    } else {
      const int length = wide ? 1 : 0, last = (~second & 15) << 3 | length << 2 | prefix;
      if (map == 1 && (rm & 8) == 0)
        bytes({0xC5, (first & 8 ? 0 : 0x80) | last});
      else
        bytes({0xC4, (first & 8 ? 0 : 0x80) | 0x40 | (rm & 8 ? 0 : 0x20) | map,
               (is_fused(one.code) && !is_single() ? 0x80 : 0) | last});
    }
    byte(opcode);
    if (!memory) return byte(0xC0 | (first & 7) << 3 | (rm & 7));
    const int size = !evex ? 1 : spread || one.code == Code::spread ? target_.number : target_.vector();
    address(first & 7, one.place, size);
  }

  static int register_of(const Place& place) {
    if (place.base == Place::pool) return 5;
    return place.base == Place::frame ? rsp : base_registers[static_cast<std::size_t>(place.base)];
  }
  /// The operand in memory. With EVEX a short displacement counts operands of `size` bytes.
  void address(int field, const Place& place, int size) {
    if (place.base == Place::pool) {  // relative to the next instruction
      byte(field << 3 | 5);
      return number(place.offset - static_cast<int>(out_.size()) - 4);
    }
    const int r = register_of(place) & 7, x = place.offset;
    const bool none = x == 0 && r != 5, brief = x % size == 0 && x / size >= -128 && x / size < 128;
    byte((none ? 0 : brief ? 0x40 : 0x80) | field << 3 | r);
    if (r == rsp) byte(0x24);
    if (none) return;
    if (brief) return byte(x / size & 0xFF);
    number(x);
  }

  const Function& f_;
  const Allocated& allocated_;
  const Target& target_;
  std::vector<std::uint8_t> out_;
};

}  // namespace

Bytes encode_x86(const Function& function, const Allocated& allocated, const Target& target) {
  return Encoder(function, allocated, target).run();
}

Bytes encode_x86_run(int entry_size) {
  MT_REQUIRE(entry_size > 0 && entry_size < 128, "entries are short");
  return {{0x41, 0x56,                                               // push r14
           0x49, 0x89, 0xF6,                                         // mov r14, rsi
           0x48, 0x89, 0xD6,                                         // mov rsi, rdx
           0x4C, 0x39, 0xF7,                                         // cmp rdi, r14
           0x74, 0x0B,                                               // je end
           0xFF, 0x17,                                               // next: call [rdi]
           0x48, 0x83, 0xC7, static_cast<std::uint8_t>(entry_size),  // add rdi, entry_size
           0x4C, 0x39, 0xF7,                                         // cmp rdi, r14
           0x75, 0xF5,                                               // jne next
           0xC5, 0xF8, 0x77,                                         // end: vzeroupper
           0x41, 0x5E,                                               // pop r14
           0xC3},                                                    // ret
          0};
}

Bytes encode_x86_call(int place) {
  MT_REQUIRE(place >= 0 && place < 128, "what entries point to begins with these pointers");
  return {{0xC5, 0xF8, 0x77,  // vzeroupper
           0x57, 0x56,        // push rdi, rsi
           0x48, 0x83, 0xEC,
           0x08,  // sub rsp, 8
           0x48, 0x8B, 0x47,
           0x08,                                          // mov rax, [rdi + 8]
           0xFF, 0x50, static_cast<std::uint8_t>(place),  // call [rax + place]
           0x48, 0x83, 0xC4,
           0x08,        // add rsp, 8
           0x5E, 0x5F,  // pop rsi, rdi
           0xC3},       // ret
          0};
}

Bytes with_arguments_x86(Bytes function, const void* context) {
  std::vector<std::uint8_t>& all = function.all;
  const auto bytes = [&](std::initializer_list<int> some) {
    for (const int x : some) all.push_back(static_cast<std::uint8_t>(x));
  };
  const auto number = [&](std::uint64_t x, int size) {
    for (int i = 0; i < size; ++i) all.push_back(static_cast<std::uint8_t>(x >> 8 * i));
  };
  const std::size_t body = std::exchange(function.entry, all.size());
  static_assert(sizeof(CalledWith) == 64 && offsetof(CalledWith, context) == 48 && offsetof(CalledWith, zero) == 56);
  bytes({0x48, 0x83, 0xEC, 0x48,                                      // sub rsp, 72
         0x48, 0x89, 0x3C, 0x24, 0x48, 0x89, 0x74, 0x24, 0x08,        // mov [rsp], rdi; mov [rsp + 8], rsi
         0x48, 0x89, 0x54, 0x24, 0x10, 0x48, 0x89, 0x4C, 0x24, 0x18,  // … rdx, rcx
         0x4C, 0x89, 0x44, 0x24, 0x20, 0x4C, 0x89, 0x4C, 0x24, 0x28,  // … r8, r9
         0x48, 0xB8});                                                // mov rax, context
  number(reinterpret_cast<std::uintptr_t>(context), 8);
  bytes({0x48, 0x89, 0x44, 0x24, 0x30,                   // mov [rsp + 48], rax
         0x48, 0xC7, 0x44, 0x24, 0x38, 0,    0,   0, 0,  // mov qword [rsp + 56], 0
         0x48, 0x89, 0xE7, 0x48, 0x89, 0xCE, 0xE8});     // mov rdi, rsp; mov rsi, rcx; call the function
  number(body - (all.size() + 4), 4);
  bytes({0x48, 0x83, 0xC4, 0x48, 0xC3});  // add rsp, 72; ret
  return function;
}

bool processor_runs([[maybe_unused]] const Target& target) noexcept {
#ifdef __x86_64__
  if (target.avx512 || target.registers > 16 || target.vector() == 64)
    return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq");
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

}  // namespace momentree::machine
