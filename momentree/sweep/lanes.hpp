#pragma once
// Which worlds of a sweep run together in SIMD lanes, and on which instruction set.
#include <optional>
#include <string>
#include <string_view>

#include <momentree/math/isa.hpp>
#include <momentree/sweep/sweep.hpp>

namespace momentree::sweep {

/// The instruction set of the lanes; nothing: every world is a simulation of its own. Results have the bits of `momentree run` in
/// either case, except in lanes for which this processor makes no machine code although it makes some for single worlds.
using Lanes = std::optional<Isa>;

/// The lanes of that name: "none", "baseline", "avx2", "avx512", or "auto" for the widest that this CPU has. Throws Error for an
/// unknown name, and for a set that this CPU or this build does not have.
Lanes lanes_of(std::string_view name);
/// `wanted`, or none if lanes save no time: see ScenarioWorlds::gain_by_lanes().
Lanes lanes_for(const Sweep& sweep, Lanes wanted);
/// What the last bits of results depend on: the version of momentree, and whether it makes machine code here.
std::string program_text(Lanes lanes);

}  // namespace momentree::sweep
