// [[coupling]]: a joint that follows another, exactly or through a spring; and `mimic` of a mechanism, which couples the joints
// of a model.
#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_set>
#include <utility>

#include <momentree/model/start.hpp>
#include <momentree/models/import/follow_circles.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr const char* spring_hint = "of the spring by which one joint follows the other: stiffness = 1e4";
constexpr Key mimic_entries[] = {
    {"stiffness", number("SI units of each joint that follows", Range::positive), "Stiffness of the spring", nullptr,
     spring_hint},
    {"damping", number("SI units of each joint that follows", Range::not_negative), "Damping", "0"},
};

constexpr Key coupling_entries[] = {
    {"joint", string, "Full name of the joint that follows; it has one DoF", nullptr,
     "the joint that follows, for example \"hand/finger2\""},
    {"follows", string, "Full name of the joint that leads; it has one DoF. Without it the joint is held at `offset`"},
    {"multiplier", number(dimension::number), "The joint is at multiplier·q + offset, where q is its leader's coordinate", "1"},
    {"offset", number("rad or m"), "Offset", "0"},
    {"polynomial", other(R"({"type": "array", "items": {"type": "number"}, "minItems": 1, "maxItems": 5})"),
     "a0 … a4: the joint is at a0 + a1·q + a2·q² + a3·q³ + a4·q⁴, in SI units; instead of multiplier and offset"},
    {"stiffness", number("N m/rad or N/m of the joint", Range::positive),
     "Stiffness of a spring by which the joint follows; without it, it follows exactly"},
    {"damping", number("N m s/rad or N s/m of the joint", Range::not_negative), "Damping of the spring", "0"},
};

/// True for a joint with one DoF whose coordinate is a length.
bool is_length(const JointSpec& joint) { return info(joint.kind).q_units[0] == 'm'; }

}  // namespace

JointId coupled_joint(const Value& value, const char* key, bool driven, Reading& reading) {
  Diagnostics& out = reading.out;
  const auto name = read_string(value, key, out);
  if (!name || reading.opaque.contains(mechanism_of(*name))) return {-1};
  if (!reading.joints.contains(*name)) {
    out.error(value.place, std::string(key) + ": there is no joint " + in_quotes(*name), reading.suggest(*name, reading.joints));
    return {-1};
  }
  const auto body = reading.body_of_joint.find(*name);
  const std::string& carried = body == reading.body_of_joint.end() ? *name : body->second;
  const Model& model = reading.scenario.model;
  if (model.has_joint(*name) && is_loop(model.joint(*name))) {
    out.error(value.place, std::string(key) + ": joint " + in_quotes(*name) + " closes a loop, where it can't be coupled",
              "let another joint of the loop be the one that closes it");
    return {-1};
  }
  if (!model.has_body(carried)) return {-1};  // of a mechanism with errors
  const JointId joint = model.inboard_joint(model.body(carried));
  const JointSpec& spec = model[joint].joint;
  if (info(spec.kind).nv != 1) {
    out.error(value.place,
              std::string(key) + ": joint " + in_quotes(*name) + " is " + std::string(info(spec.kind).name) +
                  ", and does not have one degree of freedom",
              "couple revolute, prismatic and helical joints");
    return {-1};
  }
  if (driven && spec.parameters.drive && spec.parameters.drive->moves()) {
    out.error(value.place, std::string(key) + ": the motion of joint " + in_quotes(*name) + " is prescribed",
              "drive it by position control: drive = { pd = { … } }");
    return {-1};
  }
  return joint;
}

constinit const KeyTable mimic_table{"mimic", "", "Spring that couples the joints that the model file declares as mimic",
                                     mimic_entries};
constinit const KeyTable coupling_table{
    .name = "[[coupling]]",
    .definition = "coupling",
    .about = "A coupling, which makes a joint follow another, exactly or by a spring between their coordinates",
    .own = coupling_entries,
    .details =
        "The joint is at multiplier·q(follows) + offset. At the start a joint that follows exactly takes the position and "
        "velocity that follow; ``sim.world.couplings`` has the effort of an exact coupling. With a stiffness it follows by a "
        "spring and a damper. A coupling ends when one of the joints breaks, becomes free or is changed."};

void read_coupling_spring(Fields& fields, bool along_axis, elements::SpringCoupling& spring) {
  const Dimension effort = along_axis ? dimension::force : dimension::torque,
                  way = along_axis ? dimension::length : dimension::angle;
  fields.require("stiffness");
  spring.stiffness = fields.number("stiffness", effort / way).value_or(0);
  spring.damping = fields.number("damping", effort * dimension::time / way).value_or(0);
}

void add_spring_coupling(const elements::SpringCoupling& coupling, Place place, Reading& reading) {
  const Model& model = reading.scenario.model;
  const BodySpec &joint = model[coupling.joint], &leader = model[coupling.follows];
  const double own = start_coordinates(joint).of(0), led = coupling.multiplier * start_coordinates(leader).of(0);
  const double apart = own - led - coupling.offset;
  const double size = std::abs(own) + std::abs(led) + std::abs(coupling.offset);
  if (std::abs(apart) > 1e-9 * size + 1e-12) {
    const char* const unit = is_length(joint.joint) ? "m" : "rad";
    reading.out.warning(place,
                        "joint " + in_quotes(joint.joint_name) + " starts " + rounded_text(apart, 4) + " " + unit +
                            " from where it should follow " + in_quotes(leader.joint_name),
                        "the spring pulls it there from the start");
  }
  reading.scenario.model.add_element(coupling);
  reading.element_places.push_back(place);
}

void add_exact_coupling(const Coupling& coupling, const CouplingPlace& place, Reading& reading) {
  Model& model = reading.scenario.model;
  const std::vector<CouplingProblem> problems = check_coupling(coupling, model);
  for (const CouplingProblem& problem : problems) {
    const std::string what = "coupling: " + problem.field + ": " + problem.what;
    if (place.file != nullptr)
      place.file->error({place.element}, what, problem.hint);
    else
      reading.out.error(place.place, what, problem.hint);
  }
  if (!problems.empty()) return;
  model.add_coupling(coupling);
  reading.exact_places.push_back(place);
}

namespace {

// multiplier and offset, or polynomial.
void read_law(Fields& fields, bool along, Coupling& law, Diagnostics& out) {
  const Value* const polynomial = fields.find("polynomial");
  law.multiplier = fields.number("multiplier").value_or(1);
  law.offset = fields.number("offset", along ? dimension::length : dimension::angle).value_or(0);
  if (polynomial == nullptr) return;
  if (fields.has("multiplier") || fields.has("offset"))
    return out.error(polynomial->place, "polynomial: 'multiplier' and 'offset' are its first coefficients",
                     "give either these or the polynomial");
  const Value::Array* const list = polynomial->array();
  double a[5] = {};
  std::size_t count = 0;
  if (list != nullptr && !list->empty() && list->size() <= 5)
    for (const Value& each : *list)
      if (const auto x = read_real(each, "polynomial", out)) a[count++] = *x;
  if (list == nullptr || count == 0 || count != list->size())
    return out.error(polynomial->place, "polynomial: expected 1 to 5 numbers in SI units",
                     "polynomial = [a0, a1, a2, a3, a4] for a0 + a1·q + a2·q² + a3·q³ + a4·q⁴");
  law.offset = a[0], law.multiplier = a[1], law.higher = {a[2], a[3], a[4]};
}

}  // namespace

void read_coupling(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  Fields fields(table, coupling_table, out);
  const std::size_t errors = out.errors();
  const bool by_spring = fields.has("stiffness");
  const Value* joint_value = fields.require("joint");
  const Value* leader_value = fields.find("follows");
  const JointId joint = joint_value ? coupled_joint(*joint_value, "joint", by_spring, reading) : JointId{-1};
  const JointId leader = leader_value ? coupled_joint(*leader_value, "follows", by_spring, reading) : JointId{-1};
  if (!by_spring) {
    Coupling exact{.joint = joint, .follows = leader};
    read_law(fields, joint.index >= 0 && is_length(reading.scenario.model[joint].joint), exact, out);
    if (const Value* damping = fields.find("damping"))
      out.error(damping->place, "damping: belongs to the spring of a coupling, and this one is exact",
                "give 'stiffness', too; or a damping to one of the joints");
    if (!leader_value && !fields.has("offset") && !fields.has("polynomial"))
      out.error(fields.place(), "[[coupling]] has no 'follows'",
                "the joint that leads, for example \"hand/finger1\"; or an 'offset' at which the joint is held");
    fields.finish();
    if (errors != out.errors() || joint.index < 0 || (leader_value && leader.index < 0)) return;
    return add_exact_coupling(exact, {fields.place(), nullptr, {}}, reading);
  }
  if (!leader_value) fields.require("follows", "the joint that leads, for example \"hand/finger1\"");
  if (const Value* polynomial = fields.find("polynomial"))
    out.error(polynomial->place, "polynomial: a spring follows by 'multiplier' and 'offset'",
              "leave 'stiffness' out: the coupling is then exact");
  const bool along = joint.index >= 0 && is_length(reading.scenario.model[joint].joint);
  elements::SpringCoupling coupling{joint, leader};
  coupling.multiplier = fields.number("multiplier").value_or(1);
  coupling.offset = fields.number("offset", along ? dimension::length : dimension::angle).value_or(0);
  read_coupling_spring(fields, along, coupling);
  fields.finish();
  if (joint.index >= 0 && joint == leader)
    out.error(leader_value->place, "follows: a joint cannot follow itself", "name another one of the same world");
  if (errors != out.errors() || joint.index < 0 || leader.index < 0) return;
  add_spring_coupling(coupling, fields.place(), reading);
}

void check_couplings(Reading& reading) {
  const Model& model = reading.scenario.model;
  std::vector<std::pair<int, int>> pairs;
  std::vector<Place> places;
  for (std::size_t i = 0; i < model.elements().size(); ++i)
    if (const auto* const spring = std::get_if<elements::SpringCoupling>(&model.elements()[i])) {
      pairs.emplace_back(spring->joint.index, spring->follows.index);
      places.push_back(reading.element_places[i]);
    }
  for (const std::vector<int>& circle : circles_of(pairs)) {
    const auto first = std::find(pairs.begin(), pairs.end(), std::pair(circle[0], circle[1]));
    reading.out.error(places[static_cast<std::size_t>(first - pairs.begin())],
                      "coupling: " + circle_text(circle, [&](int joint) { return in_quotes(model[JointId{joint}].joint_name); }),
                      "one of them must lead and follow no other");
  }
  std::unordered_set<std::string_view> coupled;
  for (const JointElement& each : model.elements())
    for (const JointId joint : joints_of(each)) coupled.insert(model[joint].joint_name);
  for (const Coupling& each : model.couplings()) {
    coupled.insert(model[each.joint].joint_name);
    if (each.leads()) coupled.insert(model[each.follows].joint_name);
  }
  for (const ScenarioEvent& event : reading.scenario.events)
    for (std::size_t a = 0; a < event.actions.size(); ++a) {
      if (event.actions[a]->effect() != JointEffect::replaced) continue;
      for (const std::string& joint : event.actions[a]->joints())
        if (coupled.contains(joint))
          reading.out.error(event.places[a],
                            std::string(event.actions[a]->key()) + ": joint " + in_quotes(joint) + " is coupled to another",
                            "coupled joints may break, lock and be freed, but not be changed");
    }
}

}  // namespace momentree::io
