// Random springs between points of bodies.
#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

void add_springs(Draft& draft) {
  Choices& choose = draft.choose;
  int number = 0;
  for (int left = choose.chance(0.3) ? choose.integer(1, 3) : 0; left > 0; --left) {
    const std::string from = choose.pick(draft.bodies), to = choose.chance(0.4) ? "ground" : choose.pick(draft.bodies);
    if (from == to) continue;
    const std::string name = "spring " + std::to_string(++number);
    Entries entries{{"name", quoted(name)}};
    const auto end = [&](const std::string& body) { return braces({{"body", quoted(body)}, {"point", choose.vector(0.5)}}); };
    const bool exchanged = choose.chance(0.5);
    entries.emplace_back("from", end(exchanged ? to : from));
    entries.emplace_back("to", end(exchanged ? from : to));
    entries.emplace_back("stiffness", choose.magnitude(-1, 0));
    if (choose.chance(0.5)) entries.emplace_back("rest", choose.number(0, 2));
    // Not both: where the damper keeps such a spring from pulling, the ledger depends on the step more than the motion does.
    if (const bool damped = choose.chance(0.5); damped)
      entries.emplace_back("damping", choose.magnitude(-2, -1));
    else if (choose.chance(0.6))
      entries.emplace_back("tension_only", "true");
    if (!draft.certain && choose.chance(0.3)) entries.emplace_back("strength", choose.magnitude(-1, 0));
    draft.text += "\n[[spring]]\n" + lines(entries);
    if (choose.chance(0.5))
      draft.text += "\n[[event]]\n" + lines({{"name", quoted("snap " + std::to_string(number))},
                                             {"at", choose.number(0, draft.until)},
                                             {"break", quoted(name)}});
  }
}

}  // namespace momentree::fuzz
