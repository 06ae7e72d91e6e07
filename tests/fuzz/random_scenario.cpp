#include <cstdlib>

#include <tests/fuzz/random_scenario.hpp>

namespace momentree::fuzz {

std::string random_scenario(Choices& choose, bool mixed) {
  Draft draft{choose};
  draft.mixed = mixed;
  const std::string method = draft.mixed ? choose.word({"rk4", "rk4", "dopri5", "dop853", "stepping"})
                                         : choose.word({"rk4", "rk4", "rk4", "midpoint", "damped", "dopri5", "dop853"});
  const bool adaptive = method.starts_with("dop");
  draft.heavy = method == "damped";
  draft.certain = choose.chance(0.3);
  const std::string until = draft.mixed ? choose.word({"0.1", "0.2", "0.3"}) : choose.word({"0.2", "0.3", "0.5", "0.7", "1"});
  draft.until = std::atof(until.c_str());
  draft.text = "format = 1\n";
  if (draft.mixed) {
    draft.text += "[world]\ngravity = " + choose.word({"[0, 0, -9.81]", "[0, 0, -9.81]", "[1, 2, -3]", "[0, 0, 0]"}) + "\n";
    if (choose.chance(0.8)) {
      Entries floor = random_contact_law(choose);
      if (choose.chance(0.3)) floor.emplace_back("height", choose.number(-0.2, 0.1));
      floor.emplace_back("normal", choose.word({"[0, 0, 1]", "[0, 0, 1]", "[0, 0.3, 1]"}));
      draft.text += "floor = " + braces(floor) + "\n";
    }
  } else if (choose.chance(0.5))
    draft.text += "[world]\ngravity = " + choose.word({"[0, 0, 0]", "[0, 0, 0]", "[0, -9.81, 0]", "[1, 2, -3]"}) + "\n";
  Entries integrate{{"method", quoted(method)}, {"until", until}};
  integrate.emplace_back("step", choose.word(method == "midpoint" ? std::vector<std::string>{"1e-3", "2e-3"}
                                                                  : std::vector<std::string>{"1e-3", "2e-3", "4e-3", "0.003"}));
  if (adaptive) integrate.emplace_back("rtol", choose.word({"1e-6", "1e-8", "1e-9"}));
  if (adaptive && choose.chance(0.3)) integrate.emplace_back("atol", choose.word({"1e-8", "1e-10"}));
  if (adaptive && choose.chance(0.3)) integrate.emplace_back("max_step", choose.word({"0.01", "0.03"}));
  if (choose.chance(0.1)) integrate.emplace_back("event_tolerance", choose.word({"1e-8", "1e-11"}));
  if (draft.mixed) integrate.emplace_back("resolve", "true");
  if (draft.mixed && choose.chance(0.2)) integrate.emplace_back("simultaneous", "\"in_turn\"");
  draft.text += "[integrate]\n" + lines(integrate);
  if (choose.chance(0.85)) draft.text += "[output]\nevery = " + choose.word({"0.05", "0.02", "0.037", "0.1"}) + "\n";

  const int most = choose.integer(1, draft.mixed ? 6 : 10), mechanisms = choose.integer(1, 3);
  for (int left = most, m = 0; m < mechanisms && left > 0; ++m) left -= add_mechanism(draft, left);
  add_couplings(draft);
  add_forces(draft);
  add_springs(draft);
  if (draft.mixed) add_contacts(draft), add_cables(draft), add_loops(draft);
  for (int left = choose.integer(0, 7); left > 0; --left) add_event(draft);
  return draft.text;
}

}  // namespace momentree::fuzz
