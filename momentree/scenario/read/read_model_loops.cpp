// Joints of a model file that close loops: their parameters are those of the file, with the tables of the mechanism.
#include <string>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/scenario/keys/joint_tables.hpp>

namespace momentree::io {

bool check_loop_starts(const Import& import, const MechanismState& state, Reading& reading) {
  const std::size_t errors = reading.out.errors();
  for (const ImportedLoop& loop : import.model.loops)
    if (const auto given = state.joints.find(loop.spec.name); given != state.joints.end())
      reading.out.error(given->second->place, "state: joint " + in_quotes(loop.spec.name) + " " + no_loop_start,
                        no_loop_start_hint);
  return errors == reading.out.errors();
}

void read_model_loops(const Import& import, const std::string& mechanism, const ModelChoice& choice, JointTables& joints,
                      int first, std::size_t errors, Reading& reading) {
  for (const ImportedLoop& loop : import.model.loops) {
    LoopSpec spec = loop.spec;
    joints.apply(spec.name, spec);
    take_limits(loop.limits, choice, spec.name, spec.joint.parameters, reading);
    spec.name = mechanism + "/" + spec.name;
    if (spec.to == ground)
      spec.at = choice.pose * spec.at;
    else
      spec.to.index += first;
    spec.body.index += first;
    reading.joints.emplace(spec.name, choice.model_place);
    if (errors != reading.out.errors()) continue;
    reading.from_model.emplace(spec.name, loop.spots);
    reading.scenario.model.add_loop(std::move(spec));
  }
}

}  // namespace momentree::io
