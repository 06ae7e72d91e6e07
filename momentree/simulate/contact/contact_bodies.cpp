#include <momentree/simulate/contact/contact_bodies.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include <momentree/simulate/events/of_contact.hpp>

namespace momentree {

ContactBodies::ContactBodies(const Model& model, std::string_view name) : model_(&model) {
  if (model.has_body(name))
    body_ = model.body(name);
  else if (name != "ground" && name != "floor")
    mechanism_ = name;
}

bool ContactBodies::holds(BodyId body) const {
  if (!mechanism_) return body == body_;
  return body != ground && holds(std::string_view((*model_)[body].name));
}

bool ContactBodies::holds(std::string_view body) const {
  if (!mechanism_) return body == (body_ == ground ? std::string_view("ground") : (*model_)[body_].name);
  return body.size() > mechanism_->size() && body.starts_with(*mechanism_) && body[mechanism_->size()] == '/';
}

bool ContactBodies::empty() const {
  return mechanism_ && std::none_of(model_->bodies().begin(), model_->bodies().end(),
                                    [this](const BodySpec& body) { return holds(std::string_view(body.name)); });
}

bool ContactBodies::exist(const World& world) const {
  if (!mechanism_) return body_ == ground || world.alive(body_);
  for (int b = 0; b < model_->size(); ++b)
    if (holds(BodyId{b}) && world.alive({b})) return true;
  return false;
}

namespace {

std::string quoted(const std::string& name) { return name == "ground" || name == "floor" ? "the ground" : "'" + name + "'"; }

Error no_such_solid(const Model& model, std::string_view key, const std::string& name) {
  std::vector<std::string> known;
  for (const BodySpec& body : model.bodies()) {
    known.push_back(body.name);
    if (const std::size_t slash = body.name.find('/'); slash != std::string::npos) known.push_back(body.name.substr(0, slash));
  }
  return {std::string(key) + ": there is no body or mechanism '" + name + "'", "", did_you_mean(name, known)};
}

// Those that have something to touch with.
std::vector<BodyId> with_colliders(const Model& model, const ContactBodies& bodies) {
  std::vector<BodyId> all;
  for (const Collider& collider : model.colliders())
    if (bodies.holds(collider.body) && std::find(all.begin(), all.end(), collider.body) == all.end())
      all.push_back(collider.body);
  return all;
}

}  // namespace

std::optional<Error> cannot_touch(const Model& model, const Quantity& what) {
  const auto* const of = dynamic_cast<const OfContact*>(&what);
  if (of == nullptr) return std::nullopt;
  const std::string key = std::string(what.key()) + ": ";
  std::vector<BodyId> sets[2];
  for (const int i : {0, 1}) {
    const std::string& name = i == 0 ? of->one : of->other;
    const ContactBodies bodies(model, name);
    if (bodies.empty()) return no_such_solid(model, what.key(), name);
    sets[i] = with_colliders(model, bodies);
    if (!sets[i].empty()) continue;
    const bool floor = bodies.holds(ground), one = model.has_body(name);
    return Error{key + quoted(name) + " touches nothing", "",
                 floor ? "give the world a floor"
                 : one ? "give the body a collision"
                       : "give one of its bodies a collision"};
  }
  const std::string pair = quoted(of->one) + " and " + quoted(of->other);
  bool any = false, shared = false, touch = false, rough = false;
  for (const BodyId one : sets[0])
    for (const BodyId other : sets[1]) {
      (one == other ? shared : any) = true;
      if (one == other || (touch && (rough || !of->needs_friction()))) continue;
      const ContactLaw law = model.contact_law(one, other);
      touch = touch || !law.off, rough = rough || (!law.off && law.static_friction > 0);
    }
  if (!any) return Error{key + pair + " are the same body", "", "name two bodies, or mechanisms"};
  if (shared && of->is_sum())
    return Error{key + pair + " have bodies in common", "", "their forces on each other have no sum: name two bodies"};
  if (!touch && of->needs_contact())
    return Error{key + pair + " pass through each other", "", "the last [[contact]] that names them says off = true"};
  if (!rough && of->needs_friction())
    return Error{key + pair + " have no friction, so that no slip begins", "", "give a speed: exceeds = \"1 mm/s\""};
  return std::nullopt;
}

}  // namespace momentree
