// Encodings: Arm Architecture Reference Manual for A-profile, chapter C7.
#include <momentree/machine/arm64.hpp>

#include <bit>
#include <cstring>
#include <utility>

#include <momentree/base/check.hpp>

namespace momentree::machine {

namespace {

constexpr int x0 = 0, x1 = 1, first_base = 2, x16 = 16, x17 = 17, sp = 31;
constexpr std::size_t most_bases = 14;    // x2 to x15
constexpr int operand = 31, result = 30;  // vector registers for what x86 reads from memory, and for results
constexpr std::uint32_t ret = 0xD65F03C0;

class Words {
 public:
  std::vector<std::uint8_t> out;

  void word(std::uint32_t x) {
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(x >> 8 * i));
  }
  /// An instruction with registers in the usual places.
  void three(std::uint32_t code, int to, int n, int m) {
    word(code | static_cast<std::uint32_t>(m) << 16 | static_cast<std::uint32_t>(n) << 5 | static_cast<std::uint32_t>(to));
  }
  void two(std::uint32_t code, int to, int n) { three(code, to, n, 0); }
  /// A load or store of `size` bytes at [n + offset].
  void access(std::uint32_t code, int t, int n, int offset, int size) {
    MT_REQUIRE(offset >= 0 && offset % size == 0 && offset / size < 4096, "places of numbers are near");
    word(code | static_cast<std::uint32_t>(offset / size) << 10 | static_cast<std::uint32_t>(n) << 5 |
         static_cast<std::uint32_t>(t));
  }
};

class Arm64Encoder {
 public:
  Arm64Encoder(const Function& function, const Allocated& allocated, const Target& target)
      : f_(function), allocated_(allocated), target_(target) {}

  Bytes run() {
    MT_REQUIRE(f_.bases.size() <= most_bases, "there is a register for each base");
    MT_REQUIRE(target_.lanes == 1 || target_.vector() == 16, "a register has 16 bytes");
    pool();
    const std::size_t entry = w_.out.size();
    const int frame = (allocated_.frame * target_.vector() + 15) / 16 * 16;
    if (frame > 0) move_stack(0xD1000000, frame);  // sub sp, sp, frame
    load_bases();
    for (const Instruction& one : allocated_.code) instruction(one);
    if (frame > 0) move_stack(0x91000000, frame);  // add sp, sp, frame
    w_.word(ret);
    return {std::move(w_.out), entry};
  }

 private:
  bool wide() const { return target_.lanes > 1; }
  bool is_single() const { return target_.number == 4; }
  /// One of the codes of an instruction: on a double, on a float, on two doubles, on four floats.
  std::uint32_t of(std::uint32_t d, std::uint32_t s, std::uint32_t d2, std::uint32_t s4) const {
    return wide() ? is_single() ? s4 : d2 : is_single() ? s : d;
  }

  void pool() {
    const auto put = [&](double x) {
      std::uint8_t bytes[8];
      const auto single = static_cast<float>(x);
      if (is_single())
        std::memcpy(bytes, &single, 4);
      else
        std::memcpy(bytes, &x, 8);
      for (int i = 0; i < target_.lanes; ++i) w_.out.insert(w_.out.end(), bytes, bytes + target_.number);
    };
    for (const double x : f_.pool) put(x);
    while (w_.out.size() % 16 != 0) w_.out.push_back(0);
  }

  void move_stack(std::uint32_t code, int bytes) {
    const auto by = static_cast<std::uint32_t>(bytes);
    if (by >= 4096) w_.word(code | 1u << 22 | (by >> 12) << 10 | sp << 5 | sp);
    if (by % 4096 != 0) w_.word(code | (by & 4095) << 10 | sp << 5 | sp);
  }
  void load_bases() {
    for (std::size_t i = 0; i < f_.bases.size(); ++i) load_base(first_base + static_cast<int>(i), f_.bases[i]);
  }
  void call(const Call& to) {
    MT_REQUIRE(to.memory < 4096 * 1000 && to.index < 65536, "memory and numbers of calls are few");
    const auto memory = static_cast<std::uint32_t>(to.memory) + 32;
    w_.word(0xA9BE07E0);                                       // stp x0, x1, [sp, -32]!
    w_.word(0xF9000BFE);                                       // str x30, [sp, 16]
    w_.word(0x91000000 | memory % 4096 << 10 | sp << 5 | x1);  // add x1, sp, 32 + …
    if (memory >= 4096) w_.word(0x91400000 | (memory >> 12) << 10 | x1 << 5 | x1);
    w_.word(0x52800000 | static_cast<std::uint32_t>(to.index) << 5 | 2);  // mov w2, index
    w_.access(0xF9400000, x16, x0, to.context, 8);                        // ldr x16, [x0, context]
    w_.access(0xF9400000, x16, x16, to.function, 8);                      // ldr x16, [x16, function]
    w_.word(0xD63F0200);                                                  // blr x16
    w_.word(0xF9400BFE), w_.word(0xA8C207E0);                             // ldr x30, [sp, 16]; ldp x0, x1, [sp], 32
    load_bases();
  }
  void load_base(int r, const Base& base) {
    if (base.memory < 0) return w_.access(0xF9400000, r, x0, base.entry, 8);  // ldr
    w_.access(0xB9800000, x16, x0, base.entry, 4);                            // ldrsw
    w_.access(0xF9400000, r, x1, base.memory, 8);                             // ldr
    if (base.times == 1) return w_.three(0x8B000000, r, r, x16);              // add
    MT_REQUIRE(base.times > 0 && base.times < 65536, "arrays of structures of bodies");
    w_.word(0x52800000 | static_cast<std::uint32_t>(base.times) << 5 | x17);  // mov w17, times
    w_.word(0x9B000000u | x17 << 16 | static_cast<std::uint32_t>(r) << 10 | x16 << 5 | static_cast<std::uint32_t>(r));  // madd
  }

  void load(int r, const Place& place) {
    if (place.base == Place::pool) {  // relative to this instruction
      const auto words = (place.offset - static_cast<int>(w_.out.size())) / 4;
      w_.word(of(0x5C000000, 0x1C000000, 0x9C000000, 0x9C000000) | (static_cast<std::uint32_t>(words) & 0x7FFFF) << 5 |
              static_cast<std::uint32_t>(r));
    } else if (place.shared && wide()) {
      w_.access(is_single() ? 0xBD400000 : 0xFD400000, r, base_of(place), place.offset, target_.number);
      w_.two(is_single() ? 0x4E040400 : 0x4E080400, r, r);  // dup
    } else {
      w_.access(of(0xFD400000, 0xBD400000, 0x3DC00000, 0x3DC00000), r, base_of(place), place.offset, target_.vector());
    }
  }
  static int base_of(const Place& place) { return place.base == Place::frame ? sp : first_base + place.base; }

  void move(int to, int from) {
    wide() ? w_.three(0x4EA01C00, to, from, from) : w_.two(is_single() ? 0x1E204000 : 0x1E604000, to, from);
  }
  void negate(int to, int from) { w_.two(of(0x1E614000, 0x1E214000, 0x6EE0F800, 0x6EA0F800), to, from); }

  void instruction(const Instruction& one) {
    int other = one.other;
    const bool reads = one.code != Code::load && one.code != Code::spread && one.code != Code::store &&
                       one.code != Code::flip_sign && one.code != Code::call;
    if (reads && other < 0) load(other = operand, one.place);
    const auto arithmetic = [&](std::uint32_t code) { w_.three(code, one.to, one.from, other); };
    switch (one.code) {
      case Code::load:
      case Code::spread: return load(one.to, one.place);
      case Code::store:
        return w_.access(of(0xFD000000, 0xBD000000, 0x3D800000, 0x3D800000), one.from, base_of(one.place), one.place.offset,
                         target_.vector());
      case Code::move: return move(one.to, other);
      case Code::add: return arithmetic(of(0x1E602800, 0x1E202800, 0x4E60D400, 0x4E20D400));
      case Code::subtract: return arithmetic(of(0x1E603800, 0x1E203800, 0x4EE0D400, 0x4EA0D400));
      case Code::multiply: return arithmetic(of(0x1E600800, 0x1E200800, 0x6E60DC00, 0x6E20DC00));
      case Code::divide: return arithmetic(of(0x1E601800, 0x1E201800, 0x6E60FC00, 0x6E20FC00));
      case Code::maximum:  // fcmgt, bsl
        w_.three(of(0x7EE0E400, 0x7EA0E400, 0x6EE0E400, 0x6EA0E400), result, one.from, other);
        w_.three(0x6E601C00, result, one.from, other);
        return move(one.to, result);
      case Code::call: return call(f_.calls[static_cast<std::size_t>(one.place.offset)]);
      case Code::flip_sign: return negate(one.to, one.from);
      case Code::fused_132: return fused(one, one.to, other, one.from);
      case Code::fused_213: return fused(one, one.from, one.to, other);
      case Code::fused_231: return fused(one, one.from, other, one.to);
    }
  }
  /// a b + c and so on, to one.to.
  void fused(const Instruction& one, int a, int b, int c) {
    if (!wide()) {  // fmadd, fnmsub, fmsub
      constexpr std::uint32_t codes[] = {0x1F400000, 0x1F608000, 0x1F408000};
      return w_.three((codes[one.variant] ^ (is_single() ? 0x00400000u : 0u)) | static_cast<std::uint32_t>(c) << 10, one.to, a,
                      b);
    }
    const int sum = c == one.to && a != c && b != c ? c : result;  // fmla and fmls add to it
    if (one.variant == 1)
      negate(sum, c);
    else if (sum != c)
      move(sum, c);
    w_.three(one.variant == 2 ? of(0, 0, 0x4EE0CC00, 0x4EA0CC00) : of(0, 0, 0x4E60CC00, 0x4E20CC00), sum, a, b);
    if (sum != one.to) move(one.to, sum);
  }

  const Function& f_;
  const Allocated& allocated_;
  const Target& target_;
  Words w_;
};

/// Words of a loop or a call.
Bytes code_of(std::initializer_list<std::uint32_t> words) {
  Words w;
  for (const std::uint32_t x : words) w.word(x);
  return {std::move(w.out), 0};
}

}  // namespace

Bytes encode_arm64(const Function& function, const Allocated& allocated, const Target& target) {
  return Arm64Encoder(function, allocated, target).run();
}

Bytes encode_arm64_run(int entry_size) {
  MT_REQUIRE(entry_size > 0 && entry_size < 4096, "entries are short");
  return code_of({0xA9BE4FFE,  // stp x30, x19, [sp, -32]!
                  0x6DBC27E8,
                  0x6D012FEA,
                  0x6D0237EC,
                  0x6D033FEE,  // stp d8, d9, [sp, -64]! … d15
                  0xAA0103F3,  // mov x19, x1
                  0xAA0203E1,  // mov x1, x2
                  0xEB13001F,
                  0x540000C0,  // cmp x0, x19; b.eq end
                  0xF9400010,
                  0xD63F0200,                                                 // next: ldr x16, [x0]; blr x16
                  0x91000000 | static_cast<std::uint32_t>(entry_size) << 10,  // add x0, x0, entry_size
                  0xEB13001F,
                  0x54FFFF81,  // cmp x0, x19; b.ne next
                  0x6D412FEA,
                  0x6D4237EC,
                  0x6D433FEE,
                  0x6CC427E8,  // end: ldp d10, d11 … d8, d9, [sp], 64
                  0xA8C24FFE,
                  ret});  // ldp x30, x19, [sp], 32
}

Bytes encode_arm64_call(int place) {
  MT_REQUIRE(place >= 0 && place % 8 == 0 && place < 32760, "what entries point to begins with these pointers");
  return code_of({0xA9BE07E0, 0xF9000BFE,                                    // stp x0, x1, [sp, -32]!; str x30, [sp, 16]
                  0xF9400410,                                                // ldr x16, [x0, 8]
                  0xF9400210 | static_cast<std::uint32_t>(place / 8) << 10,  // ldr x16, [x16, place]
                  0xD63F0200,                                                // blr x16
                  0xF9400BFE, 0xA8C207E0, ret});                             // ldr x30, [sp, 16]; ldp x0, x1, [sp], 32
}

Bytes with_arguments_arm64(Bytes function, const void* context) {
  Words w;
  w.out = std::move(function.all);
  while (w.out.size() % 8 != 0) w.out.push_back(0);
  const auto address = static_cast<std::int32_t>(w.out.size());
  const auto bits = reinterpret_cast<std::uintptr_t>(context);
  w.word(static_cast<std::uint32_t>(bits)), w.word(static_cast<std::uint32_t>(static_cast<std::uint64_t>(bits) >> 32));
  const auto body = static_cast<std::int32_t>(std::exchange(function.entry, w.out.size()));
  const auto words_to = [&](std::int32_t place) {
    return static_cast<std::uint32_t>((place - static_cast<std::int32_t>(w.out.size())) / 4);
  };
  w.word(0xD10283FF);                                                              // sub sp, sp, 160
  w.word(0xA90007E0), w.word(0xA9010FE2), w.word(0xA90217E4);                      // stp x0, x1, [sp]; x2, x3; x4, x5
  w.word(0x58000000 | (words_to(address) & 0x7FFFF) << 5 | x16);                   // ldr x16, context
  w.word(0xA9037FF0);                                                              // stp x16, xzr, [sp, 48]
  w.word(0xF90023FE);                                                              // str x30, [sp, 64]
  w.word(0x6D0527E8), w.word(0x6D062FEA), w.word(0x6D0737EC), w.word(0x6D083FEE);  // stp d8, d9, [sp, 80] …
  w.word(0xAA0303E1), w.word(0x910003E0);                                          // mov x1, x3; mov x0, sp
  w.word(0x94000000 | (words_to(body) & 0x3FFFFFF));                               // bl
  w.word(0x6D4527E8), w.word(0x6D462FEA), w.word(0x6D4737EC), w.word(0x6D483FEE);  // ldp d8, d9, [sp, 80] …
  w.word(0xF94023FE);                                                              // ldr x30, [sp, 64]
  w.word(0x910283FF);                                                              // add sp, sp, 160
  w.word(ret);
  function.all = std::move(w.out);
  return function;
}

}  // namespace momentree::machine
