#include <momentree/scenario/state/state_coupling.hpp>

namespace momentree::io {

void read_coupling_states(const Value& list, const Model& model, Forest& forest, Diagnostics& out) {
  const Value::Array* const all = list.array();
  if (all == nullptr || all->size() != model.couplings().size())
    return out.error(
        list.place,
        "couplings: expected a list of the " + std::to_string(model.couplings().size()) + " couplings of the scenario",
        "is the document of another scenario?");
  for (std::size_t c = 0; c < all->size(); ++c) {
    const Coupling& coupling = model.couplings()[c];
    Fields fields((*all)[c], "a coupling", out, "");
    const auto is = [&](const char* key, JointId joint) {
      const auto name = fields.string(key);
      const std::string expected = joint.index < 0 ? std::string() : model[joint].joint_name;
      if (name.value_or("") != expected)
        out.error(fields.place_of(key), std::string("couplings: ") + key + ": expected " + in_quotes(expected),
                  "the couplings are those of the scenario, in its order");
    };
    is("joint", coupling.joint);
    is("follows", coupling.follows);
    if (fields.boolean("ended").value_or(false)) forest.ended_couplings.push_back(static_cast<int>(c));
    for (const char* result : {"effort", "determined"}) fields.find(result);
    fields.finish();
  }
}

}  // namespace momentree::io
