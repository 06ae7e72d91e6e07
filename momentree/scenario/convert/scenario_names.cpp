#include <momentree/scenario/convert/scenario_names.hpp>

#include <algorithm>
#include <string>
#include <unordered_set>
#include <utility>

namespace momentree::io {

namespace {

std::string first_part(const std::string& name) { return name.substr(0, name.find('/')); }

// The root of each body, by number.
std::vector<int> roots_of(const Model& model) {
  std::vector<int> roots;
  for (int b = 0; b < model.size(); ++b) {
    const int parent = model[BodyId{b}].parent.index;
    roots.push_back(parent < 0 ? b : roots[static_cast<std::size_t>(parent)]);
  }
  return roots;
}

}  // namespace

std::vector<ScenarioName> scenario_names(const Model& model) {
  std::vector<ScenarioName> names;
  std::unordered_set<std::string> bodies, joints;
  const std::vector<int> roots = roots_of(model);
  const auto fit = [](const std::string& name, const std::string& mechanism, std::unordered_set<std::string>& used) {
    const bool has_it = name.size() > mechanism.size() && name[mechanism.size()] == '/' && first_part(name) == mechanism;
    std::string bare = has_it ? name.substr(mechanism.size() + 1) : name;
    std::replace(bare.begin(), bare.end(), '/', '.');  // a scenario's names have one slash
    std::string full = mechanism + '/' + bare;
    while (!used.insert(full).second) full += '~';
    return full;
  };
  for (int b = 0; b < model.size(); ++b) {
    const BodySpec& spec = model[BodyId{b}];
    const std::string mechanism = first_part(model[BodyId{roots[static_cast<std::size_t>(b)]}].name);
    const std::string body = fit(spec.name, mechanism, bodies);
    names.push_back({body, fit(spec.joint_name == spec.name ? body : spec.joint_name, mechanism, joints)});
  }
  return names;
}

Model with_scenario_names(const Model& model) {
  const std::vector<ScenarioName> names = scenario_names(model);
  bool same = true;
  for (int b = 0; b < model.size(); ++b) {
    const auto& [body, joint] = names[static_cast<std::size_t>(b)];
    same = same && model[BodyId{b}].name == body && model[BodyId{b}].joint_name == joint;
  }
  if (same) return model;
  Model renamed({.gravity = model.gravity()});
  for (int b = 0; b < model.size(); ++b) {
    BodySpec spec = model[BodyId{b}];
    spec.name = names[static_cast<std::size_t>(b)].body, spec.joint_name = names[static_cast<std::size_t>(b)].joint;
    renamed.add_unjudged(std::move(spec));
  }
  for (const BodyForce& force : model.forces()) renamed.add_force(force);
  for (const Spring& spring : model.springs()) renamed.add_spring(spring);
  for (const LoopSpec& loop : model.loops()) renamed.add_loop(loop);
  for (const Coupling& coupling : model.couplings()) renamed.add_coupling(coupling);
  for (const JointElement& element : model.elements()) renamed.add_element(element);
  for (const Collider& collider : model.colliders()) renamed.add_collider(collider);
  for (ContactRule rule : model.contact_rules()) {
    for (std::string* name : {&rule.one_name, &rule.other_name})
      if (model.has_body(*name)) *name = names[static_cast<std::size_t>(model.body(*name).index)].body;
    renamed.add_contact_rule(std::move(rule));
  }
  return renamed;
}

}  // namespace momentree::io
