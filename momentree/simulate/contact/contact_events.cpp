#include <momentree/simulate/contact/contact_events.hpp>

#include <cmath>

namespace momentree {

Event ContactEvents::begin(const char* what, int number) const {
  const ContactPair& pair = (*pairs_)[number];
  Event event;
  event.time = world_->time(), event.name = name(what, pair);
  event.mechanisms_before = event.mechanisms_after = world_->world().mechanism_names();
  event.before = event.after = world_->world().totals();
  event.contact.one = world_->name_of(pair.a), event.contact.other = world_->name_of(pair.b);
  if (pair.cable >= 0) event.contact.cable = pair.law_name;
  return event;
}

std::string ContactEvents::name(const char* what, const ContactPair& pair) const {
  if (pair.cable >= 0) return (std::string_view(what) == "lift" ? "slack " : "taut ") + pair.law_name;
  return pair.law_name.empty() ? what : std::string(what) + " " + pair.law_name;
}

void ContactEvents::locate(Event& event, const std::vector<Contact>& contacts, const ContactRows& rows,
                           const std::vector<double>& weights, int pair) const {
  double total = 0;
  Vec3 point{}, normal{};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].pair != pair) continue;
    const double weight = weights[i] + 1e-300;
    const double sign = contacts[i].a == (*pairs_)[pair].a ? 1 : -1;
    total += weight, point += weight * rows.touches[i].point, normal += sign * weight * rows.touches[i].normal;
  }
  if (!(total > 0)) return;
  event.contact.point = (1 / total) * point;
  event.contact.normal = norm(normal) > 0 ? normalized(normal) : Vec3{};
}

ContactEvents::Impulses ContactEvents::impulses(const std::vector<Contact>& contacts, const ContactRows& rows,
                                                const std::vector<double>& r) const {
  Impulses all;
  all.generalised.assign(static_cast<std::size_t>(world_->tree().nv()), 0.0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Vec3 impulse{};
    for (std::size_t k = 0; k < 3; ++k) {
      impulse += r[3 * i + k] * along(rows.touches[i], k);
      rows.add_row(rows.J, 3 * i + k, r[3 * i + k], all.generalised.data());
    }
    if (impulse == Vec3{}) continue;
    const Vec3 point = rows.touches[i].point;
    for (const auto& [body, sign] : {std::pair{contacts[i].a, 1.0}, {contacts[i].b, -1.0}}) {
      if (body >= 0)
        all.on_bodies.push_back({body, sign * impulse, {}, point});
      else
        all.on_ground.push_back({-1, -sign * impulse, {}, point});
    }
    const bool first = contacts[i].a == (*pairs_)[contacts[i].pair].a;
    all.by_pair[contacts[i].pair] += (first ? 1.0 : -1.0) * impulse;
  }
  return all;
}

void ContactEvents::apply(const Impulses& impulses, const ContactRows& rows, const std::vector<double>& r, TopologyEditor& editor,
                          Event& event) const {
  const double lost = event.lost;
  editor.apply_contact_impulses(impulses.generalised, impulses.on_bodies, impulses.on_ground);
  event.after = world_->world().totals();
  if (world_->tree().joints_with().motions.empty() && world_->tree().loops().motions == 0 && !rows.has_belts()) return;
  // What the contacts did not take, prescribed motions and belts brought in.
  double taken = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    taken -= r[i] * rows.velocity[i];
    for (std::size_t j = 0; j < r.size(); ++j) taken -= 0.5 * r[i] * rows.mobility(i, j) * r[j];
  }
  event.work += taken - (event.lost - lost), event.lost = lost + taken;
}

std::map<int, Vec3> StoppedMotion::stop(const std::vector<Contact>& closed, const SlowMotion& slow) {
  if (closed.empty()) return {};
  const double least = slow_approach(*world_, slow);
  const Totals before = world_->world().totals();
  ContactRows rows;
  std::vector<double> r;
  bool felt = false;
  {
    const State::Edit edit = world_->state().edit();
    if (!find_stopping_impulses(world_->tree(), edit.time, edit.q.data(), edit.u.data(), world_->workspace(), closed)) return {};
    rows = world_->workspace().contacts->rows, r = world_->workspace().contacts->change;
    for (std::size_t i = 0; i < r.size(); ++i) felt = felt || (r[i] != 0 && std::fabs(rows.velocity[i]) > least);
    for (std::size_t i = 0; i < r.size() && !felt; ++i) rows.add_row(rows.Y, i, r[i], edit.u.data());
  }
  if (!felt) {
    lost_ += before.kinetic - world_->world().totals().kinetic;
    return {};
  }
  if (!std::exchange(any_, true)) {
    event_.before = before;
    editor_.begin(event_, "");
  }
  const ContactEvents::Impulses impulses = events_->impulses(closed, rows, r);
  events_->apply(impulses, rows, r, editor_, event_);
  return impulses.by_pair;
}

void StoppedMotion::join(std::vector<Event>& events, std::size_t first, std::size_t changes) {
  if (!any_ || events.size() == first) return;
  const bool begins = changes < events.size();
  Event& whole = events[begins ? changes : changes - 1];
  if (begins)
    whole.before = event_.before;
  else
    whole.after = event_.after;
  editor_.certify_part(event_, whole);
  joined_ = true;
}

}  // namespace momentree
