#include <momentree/model/collider.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/base/wildcard.hpp>
#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/model/contact_rules.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

namespace {

constexpr BodyId nobody{-2};  // alone in a set: there is none yet, which is not the same as all

bool holds(const std::vector<BodyId>& set, BodyId body) {
  return set.empty() || std::find(set.begin(), set.end(), body) != set.end();
}

}  // namespace

ColliderId Model::add_collider(Collider collider) {
  if (collider.body != ground && (collider.body.index < 0 || collider.body.index >= size()))
    throw_error({"a collider belongs to a body of the model, or to the ground", "collision", ""});
  if (collider.plane) {
    if (collider.body != ground) throw_error({"only the ground can have a plane", "collision", "give the body a box"});
    if (!is_finite(collider.point) || !is_finite(collider.normal) || collider.normal == Vec3{})
      throw_error({"a plane has a finite point and a normal that is not zero", "normal", ""});
    collider.normal = unit(collider.normal);
  } else if (collider.field) {
    if (collider.body != ground) throw_error({"only the ground can have a height field", "collision", "give the body boxes"});
    const contact::HeightField& field = *collider.field;
    const auto finite = [](double height) { return std::isfinite(height); };
    if (!(field.x > 0 && field.y > 0) || field.columns < 2 || field.rows < 2 ||
        field.heights.size() != static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows) ||
        !std::all_of(field.heights.begin(), field.heights.end(), finite) || !is_finite(field.at.position))
      throw_error({"a height field has two rows and two columns of finite heights at least", "heights", ""});
    contact::Solid& around = collider.solid;
    around.centre = field.at * Vec3{0, 0, 0.5 * (field.lowest + field.highest)};
    around.reach = norm(Vec3{0.5 * field.x, 0.5 * field.y, 0.5 * (field.highest - field.lowest)});
    around.thickness = HUGE_VAL;
  } else {
    if (collider.solid.vertices.empty())
      throw_error({"a collider has no volume", "collision", "its points must not lie in one plane"});
    for (const Vec3& v : collider.solid.vertices)
      if (!is_finite(v)) throw_error({"the size of a collider is not finite", "collision", ""});
    if (!(collider.solid.radius >= 0) || !std::isfinite(collider.solid.radius) || !(collider.solid.thickness > 0))
      throw_error({"the size of a collider must be greater than 0", "collision", ""});
  }
  if (!is_finite(collider.solid.belt)) throw_error({"the speed of a belt is not finite", "belt", ""});
  colliders_.push_back(std::move(collider));
  return {static_cast<int>(colliders_.size()) - 1};
}

void Model::add_contact_rule(ContactRule rule) {
  for (const std::vector<BodyId>* const set : {&rule.one, &rule.other})
    for (const BodyId body : *set)
      if (body != ground && body != nobody && (body.index < 0 || body.index >= size()))
        throw_error({"a contact names bodies of the model, or the ground", "between", ""});
  const ContactLaw& law = rule.law;
  if (!(law.friction >= 0) || !std::isfinite(law.friction))
    throw_error({"a coefficient of friction can't be negative", "friction", ""});
  if (!(law.static_friction >= law.friction) || !std::isfinite(law.static_friction))
    throw_error({"the static coefficient of friction can't be smaller than the kinetic one", "friction", ""});
  if (!(law.torsional >= 0 && law.rolling >= 0) || !std::isfinite(law.torsional + law.rolling))
    throw_error({"torsional and rolling friction are lengths, which can't be negative", "friction", ""});
  if (!(law.restitution >= 0 && law.restitution <= 1))
    throw_error({"a restitution is from 0 to 1: an impact can't gain energy", "restitution", ""});
  for (const auto& [name, set] : {std::pair{&rule.one_name, &rule.one}, {&rule.other_name, &rule.other}}) {
    if (name->empty()) continue;
    for (int b = 0; b < size(); ++b)
      if (names_body(*name, (*this)[BodyId{b}].name) && (set->empty() || !holds(*set, {b}))) set->push_back({b});
    if (set->empty()) set->push_back(nobody);
  }
  contact_rules_.push_back(std::move(rule));
}

bool applies(const ContactRule& rule, BodyId one, BodyId other) {
  return (holds(rule.one, one) && holds(rule.other, other)) || (holds(rule.one, other) && holds(rule.other, one));
}

const ContactRule* Model::contact_rule(BodyId one, BodyId other) const {
  for (std::size_t i = contact_rules_.size(); i-- > 0;)
    if (applies(contact_rules_[i], one, other)) return &contact_rules_[i];
  return nullptr;
}

ContactLaw Model::contact_law(BodyId one, BodyId other) const {
  const ContactRule* const rule = contact_rule(one, other);
  return rule != nullptr ? rule->law : ContactLaw{};
}

bool touch_while_joined(const Model& model, BodyId one, BodyId other) {
  const std::vector<ContactRule>& rules = model.contact_rules();
  for (std::size_t i = rules.size(); i-- > 0;) {
    const ContactRule& rule = rules[i];
    const bool names_both = !rule.one.empty() && !rule.other.empty();
    if ((names_both || rule.law.off) && applies(rule, one, other)) return !rule.law.off;
  }
  return false;
}

}  // namespace momentree
