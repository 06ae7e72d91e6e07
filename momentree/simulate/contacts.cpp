// Pairs of solids, what is to be located within a step, and impacts; contact_states.cpp chooses what follows.
#include <momentree/simulate/contacts.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/contacts_impl.hpp>

namespace momentree {

Contacts::Contacts(World& world, Evaluator& evaluate, double tolerance, contact::Simultaneous how)
    : world_(&world), evaluate_(&evaluate), tolerance_(tolerance), simultaneous_(how) {}
Contacts::~Contacts() = default;

bool Contacts::any() {
  if (world_->model_.colliders().empty()) return false;
  if (bodies_ != world_->model_.size()) find_pairs();
  return !pairs_.empty();
}

void Contacts::find_pairs() {
  const Model& model = world_->model_;
  bodies_ = model.size();
  pairs_.clear();
  const std::vector<Collider>& all = model.colliders();
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[i].plane || all[i].body == all[k].body || (!all[k].plane && k <= i)) continue;
      // The ground is the second one.
      const bool swap = all[i].body == ground;
      const Collider &one = swap ? all[k] : all[i], &other = swap ? all[i] : all[k];
      const ContactLaw law = model.contact_law(one.body, other.body);
      if (law.off) continue;
      const double thickness = other.plane ? HUGE_VAL : std::min(one.solid.thickness, other.solid.thickness);
      const ContactRule* const rule = model.contact_rule(one.body, other.body);
      pairs_.push_back({&one, &other, law, thickness, rule != nullptr ? rule->name : std::string()});
    }
}

contact::Place Contacts::place(int body) const {
  if (body < 0) return {};
  const BodyMotion& motion = world_->motions()[static_cast<std::size_t>(body)];
  return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
}

void Contacts::candidates(const Pair& pair, double within, std::vector<contact::Candidate>& out) const {
  const Collider &one = *pair.one, &other = *pair.other;
  const contact::Place a = place(one.body.index), b = place(other.body.index);
  if (other.plane)
    contact::face_plane(one.solid, a, other.point, other.normal, b, within, out);
  else
    contact::face_each_other(one.solid, a, other.solid, b, within, out);
}

bool Contacts::is_closed(int pair, std::uint64_t id) const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  return std::any_of(closed.begin(), closed.end(), [&](const Contact& c) { return c.pair == pair && c.id == id; });
}

Contact Contacts::contact_of(const Pair& pair, int number, const contact::Candidate& candidate) const {
  Contact c;
  c.features = candidate.features, c.id = candidate.id, c.pair = number;
  c.a = pair.one->body.index, c.b = pair.other->body.index;
  if (candidate.swapped) std::swap(c.a, c.b);
  c.friction = pair.law.friction;
  return c;
}

// All contacts that touch at present, whether they are closed or not.
std::vector<Contact> Contacts::touching() {
  std::vector<Contact> all;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Pair& pair = pairs_[i];
    if (!pair.alive(*world_)) continue;
    const double size = pair.size(*this);
    if (apart(pair) > touching_within * size) continue;
    found_candidates_.clear();
    candidates(pair, touching_within * size, found_candidates_);
    for (const contact::Candidate& found : found_candidates_) all.push_back(contact_of(pair, static_cast<int>(i), found));
  }
  return all;
}

// A lower bound of the distance of two solids (m).
double Contacts::apart(const Pair& pair) const {
  const contact::Place a = place(pair.one->body.index);
  const contact::Solid& one = pair.one->solid;
  const Vec3 centre = a.r + a.R * one.centre;
  if (pair.other->plane) return dot(pair.other->normal, centre - pair.other->point) - one.reach;
  const contact::Place b = place(pair.other->body.index);
  const contact::Solid& other = pair.other->solid;
  return norm(centre - b.r - b.R * other.centre) - one.reach - other.reach;
}

// An upper bound of the speed with which points of two solids approach each other (m/s).
double Contacts::speed_bound(const Pair& pair) const {
  const contact::Place a = place(pair.one->body.index), b = place(pair.other->body.index);
  const contact::Solid &one = pair.one->solid, &other = pair.other->solid;
  const Vec3 va = a.v + cross(a.w, a.R * one.centre), vb = b.v + cross(b.w, b.R * other.centre);
  return norm(va - vb) + norm(a.w) * one.reach + (pair.other->plane ? 0.0 : norm(b.w) * other.reach);
}

// Negative where the solids of a pair overlap, apart from contacts that are closed; `within` if nothing is that near.
Contacts::Gap Contacts::gap_of(int number, double within) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  found_candidates_.clear();
  candidates(pair, within, found_candidates_);
  Gap least{within, 0};
  for (const contact::Candidate& c : found_candidates_) {
    if (!(c.gap < least.value) || is_closed(number, c.id)) continue;
    const contact::Place a = place(pair.one->body.index), b = place(pair.other->body.index);
    const contact::Place &first = c.swapped ? b : a, &second = c.swapped ? a : b;
    const contact::Touch touch = contact::touch(c.features, first, second);
    least = {touch.gap, dot(touch.normal, contact::relative_velocity(touch, first, second))};
  }
  return least;
}

std::span<const Watch> Contacts::watches(double& h) {
  watches_.clear(), conditions_.clear();
  const World& world = *world_;
  const double accelerated = norm(world.model_.gravity()) * h;  // what gravity may add to speeds within the step
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Pair& pair = pairs_[i];
    if (!pair.alive(world)) continue;
    const double speed = 2 * speed_bound(pair) + 2 * accelerated, distance = apart(pair);
    if (distance > speed * h) continue;
    // Not farther than through a part of the thinner solid, so that its end is not beyond it. Above a plane not through an angle
    // within which points come near and leave again unseen.
    double longest = 2 * std::max(distance, 0.0) / speed;
    if (pair.other->plane)
      longest = std::max(longest, 0.3 / norm(place(pair.one->body.index).w));
    else
      longest += 0.5 * std::min({pair.thickness, pair.one->solid.reach, pair.other->solid.reach}) / speed;
    if (h > longest) h = std::max(longest, 1e-9 * h);
    const double within = std::isfinite(pair.thickness) ? 0.5 * pair.thickness + 1e-9 : pair.one->solid.reach;
    conditions_.emplace_back(std::make_shared<PairGap>(*this, static_cast<int>(i), within), 0.0, false);
  }
  const std::span<const Contact> closed = world.tree_.contacts();
  if (!closed.empty()) conditions_.emplace_back(std::make_shared<Hold>(*this), 0.0, true);
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].mode == Contact::Mode::slip) {
      const Vec3 v = slip_velocity(static_cast<int>(i));
      if (norm(v) > slowest_slip)
        conditions_.emplace_back(std::make_shared<Slip>(*this, static_cast<int>(i), normalized(v)), 0.0, true);
    }
  for (const Condition& condition : conditions_) {
    const double excess = condition.excess(world, {}).value_or(-1);
    Watch watch{&condition, 0};
    watch.offset = -rounding;
    // What could not be mended at the start counts only if it grows. Flights begin at the gap at which they end.
    if (excess > 10 * rounding) watch.offset = condition.above ? -2 * excess : -excess - rounding;
    watch.start = std::min(excess + watch.offset, 0.0);
    watch.start_rate = watch.rate(world);
    watch.precise = watch.start_rate.has_value();
    watches_.push_back(watch);
  }
  return watches_;
}

bool Contacts::must_resolve() {
  if (next_rest() <= world_->time()) return true;
  for (const Watch& watch : watches_)
    if (watch.condition->excess(*world_, {}).value_or(-1) + watch.offset > -2 * touching_within) return true;
  // Slip that came to an end just before a step did has no direction left that could be watched.
  const std::span<const Contact> closed = world_->tree_.contacts();
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].mode != Contact::Mode::slip) continue;
    const Vec3 v = slip_velocity(static_cast<int>(i));
    if (norm(v) <= slowest_slip && dot(v, closed[i].direction) < 0) return true;
  }
  return false;
}

double Contacts::next_rest() const {
  double next = HUGE_VAL;
  for (const Contact& c : world_->tree_.contacts())
    if (c.settles >= 0) next = std::min(next, c.settles);
  return next;
}

std::optional<Overlap> Contacts::overlap() {
  if (!any()) return std::nullopt;
  std::optional<Overlap> worst;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Pair& pair = pairs_[i];
    if (!pair.alive(*world_) || apart(pair) > 0) continue;
    const double depth = -gap_of(static_cast<int>(i), 0).value;
    if (depth > overlapping * pair.size(*this) && (!worst || depth > worst->depth))
      worst = Overlap{name_of(pair.one->body.index), name_of(pair.other->body.index), depth};
  }
  return worst;
}

std::optional<Overlap> deepest_overlap(const Model& model) {
  if (model.colliders().empty()) return std::nullopt;
  World world(model, Variables::velocities);
  return Contacts::overlap_of(world);
}

std::optional<Overlap> Contacts::overlap_of(World& world) {
  Evaluator evaluate(world.tree_, world.workspace_);
  return Contacts(world, evaluate, 1e-10).overlap();
}

std::string Contacts::name_of(int body) const { return body < 0 ? "ground" : world_->model_[BodyId{body}].name; }

Vec3 Contacts::slip_velocity(int contact) const {
  const Contact& c = world_->tree_.contacts()[static_cast<std::size_t>(contact)];
  const contact::Place a = place(c.a), b = place(c.b);
  const contact::Touch touch = contact::touch(c.features, a, b);
  const Vec3 v = contact::relative_velocity(touch, a, b);
  return v - dot(v, touch.normal) * touch.normal;
}

double Contacts::Pair::size(const Contacts& all) const { return std::max(1.0, norm(all.place(one->body.index).r)); }
bool Contacts::Pair::alive(const World& world) const {
  return world.alive(one->body) && (other->body == ground || world.alive(other->body));
}

}  // namespace momentree
