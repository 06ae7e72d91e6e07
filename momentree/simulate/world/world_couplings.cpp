// Couplings of joints in a world.
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

// Names of the model: joints that broke have others.
std::pair<std::string, std::string> coupling_names(const World& world, CouplingId coupling) {
  const Model& model = world.model();
  const Coupling& law = model.couplings()[static_cast<std::size_t>(coupling.index)];
  return {model[law.joint].joint_name, law.leads() ? model[law.follows].joint_name : std::string()};
}

CouplingView World::coupling(CouplingId number) const {
  MT_REQUIRE(number.index >= 0 && number.index < couplings(), "the world has a coupling of that number");
  CouplingView view{model_.couplings()[static_cast<std::size_t>(number.index)], !tree_.coupling_acts(number.index), 0, true};
  if (view.ended) return view;
  accelerate(tree_, state_, workspace_);
  const int place = coupling_place(tree_, number.index);
  view.effort =
      workspace_.loops->lambda[static_cast<std::size_t>(tree_.loops().links[static_cast<std::size_t>(place)].first_row)];
  view.determined = open_parts_of_link(tree_, workspace_, place) == 0;
  return view;
}

}  // namespace momentree
