#include <momentree/sweep/lanes.hpp>

#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/batch/stepper.hpp>
#include <momentree/sweep/scenario_worlds.hpp>

namespace momentree::sweep {

namespace {
constexpr std::string_view names[] = {"baseline", "avx2", "avx512"};  // in the order of Isa
}

Lanes lanes_of(std::string_view name) {
  if (name == "none") return std::nullopt;
  if (name == "auto") return batch::best_isa();
  const auto* const found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names))
    throw_error({"there are no lanes '" + std::string(name) + "'", "", "auto, none, baseline, avx2 or avx512"});
  const auto isa = static_cast<Isa>(found - std::begin(names));
  if (!batch::available(isa))
    throw_error({"this processor or this build of momentree has no " + std::string(name) + " lanes", "",
                 "auto uses the widest that there are"});
  return isa;
}

Lanes lanes_for(const Sweep& sweep, Lanes wanted) {
  return wanted && ScenarioWorlds(sweep, wanted).gain_by_lanes() ? wanted : std::nullopt;
}

std::string program_text(Lanes lanes) {
  std::string text = MOMENTREE_VERSION;
  if (!batch::makes_machine_code(std::nullopt))
    text += " without machine code";
  else if (lanes && !batch::makes_machine_code(lanes))
    text += " with " + std::string(names[static_cast<std::size_t>(*lanes)]) + " lanes";
  return text;
}

}  // namespace momentree::sweep
