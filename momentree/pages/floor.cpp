#include <momentree/pages/floor.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree::io {

namespace {

constexpr double friction = 0.5, restitution = 0.1;
constexpr double thickness = 0.05;  // radius of a capsule, relative to its length
constexpr double room = 0.01;       // between the floor and what is above it, relative to the size of the whole
// Pages keep up with the clock. The motion between impulses has shorter steps if the scenario has.
constexpr double step = 1e-3, shortest_flight = 2.5e-4;  // s

std::size_t at(BodyId body) { return static_cast<std::size_t>(body.index); }

Vec3 up_of(const Model& model) {
  const double g = norm(model.gravity());
  return g > 0 ? (-1 / g) * model.gravity() : Vec3{0, 0, 1};
}

// From each body's inboard joint to those that it carries; of a body at the end of a chain, twice as far as its centre of mass.
std::vector<std::vector<Vec3>> lines_of(const Model& model) {
  std::vector<std::vector<Vec3>> lines(static_cast<std::size_t>(model.size()));
  for (const BodySpec& child : model.bodies())
    if (child.parent != ground) {
      const Vec3 line = child.at.position - model[child.parent].child_at.position;
      std::vector<Vec3>& own = lines[at(child.parent)];
      if (norm(line) > 0 && std::find(own.begin(), own.end(), line) == own.end()) own.push_back(line);
    }
  for (int b = 0; b < model.size(); ++b) {
    const Vec3 half = model[{b}].com - model[{b}].child_at.position;
    if (lines[at({b})].empty() && norm(half) > 0) lines[at({b})].push_back(2 * half);
  }
  return lines;
}

// A ball of uniform density with that mass and inertia, a little one for a point mass.
double radius_of(const BodySpec& body, double size) {
  const double trace = body.inertia.xx + body.inertia.yy + body.inertia.zz;
  const double radius = std::sqrt(2.5 / 3 * trace / body.mass);
  return std::clamp(radius, 0.01 * size, 0.1 * size);
}

std::vector<contact::Solid> solids_of(const BodySpec& body, const Shape& shape, const std::vector<Vec3>& lines, double size) {
  std::vector<contact::Solid> solids;
  const auto ignore = [](const std::string&, const std::string&) {};
  const auto add = [&](const Shape& each) {
    if (each.kind == Shape::Kind::none || each.kind == Shape::Kind::mesh) return;
    for (contact::Solid& solid : solids_of(each, {ignore, ignore, ignore, ignore})) solids.push_back(std::move(solid));
  };
  add(shape);
  for (const Shape& more : shape.more) add(more);
  if (!solids.empty() || (!(body.mass > 0) && lines.empty())) return solids;
  for (const Vec3& line : lines) {
    const double length = norm(line);
    const Vec3 z = (1 / length) * line;
    Vec3 across[2];
    contact::perpendiculars(z, across);
    const auto& [x, y] = across;
    const Pose middle{body.child_at.position + 0.5 * line, quaternion_of({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z})};
    solids.push_back(contact::capsule(thickness * length, (1 - 2 * thickness) * length, middle));
  }
  if (solids.empty()) solids.push_back(contact::sphere(radius_of(body, size), {body.com, {}}));
  return solids;
}

double lowest(const contact::Solid& solid, const Pose& pose, const Vec3& up) {
  double least = HUGE_VAL;
  for (const Vec3& v : solid.vertices) least = std::min(least, dot(up, pose * v));
  return least - solid.radius;
}

// How a mechanism that is connected to the ground is supported.
struct Support {
  double height = 0;    // of its joint to the ground
  double reach = 0;     // the longest way from there along its bodies
  double up = 0;        // height of its centre of mass above that joint
  double sideways = 0;  // and the horizontal distance
  bool from_above() const { return up <= sideways; }
};

Support support_of(const World& world, const Mechanism& mechanism, const std::vector<std::vector<contact::Solid>>& solids,
                   const Vec3& up) {
  const Model& model = world.model();
  const Vec3 joint = model[mechanism.root].at.position;
  Support result;
  result.height = dot(up, joint);
  double mass = 0;
  Vec3 moment{};
  std::vector<double> way(static_cast<std::size_t>(model.size()), 0);  // to the inboard joint
  for (const BodyId b : mechanism.bodies) {
    const BodySpec& body = model[b];
    const Vec3 inboard = body.child_at.position;
    if (body.parent != ground) way[at(b)] = way[at(body.parent)] + norm(body.at.position - model[body.parent].child_at.position);
    double own = norm(body.com - inboard);
    for (const contact::Solid& solid : solids[at(b)]) own = std::max(own, norm(solid.centre - inboard) + solid.reach);
    result.reach = std::max(result.reach, way[at(b)] + own);
    mass += body.mass, moment += body.mass * (world.motions()[at(b)].pose * body.com - joint);
  }
  if (mass > 0) moment = (1 / mass) * moment;
  result.up = dot(up, moment), result.sideways = norm(moment - result.up * up);
  return result;
}

const Collider* plane_of(const Model& model) {
  const auto& all = model.colliders();
  const auto found = std::find_if(all.begin(), all.end(), [](const Collider& each) { return each.plane; });
  return found == all.end() ? nullptr : &*found;
}

void pass_through(Model& model, std::vector<BodyId> one, std::vector<BodyId> other) {
  ContactRule rule;
  rule.one = std::move(one), rule.other = std::move(other), rule.law.off = true;
  model.add_contact_rule(std::move(rule));
}

}  // namespace

double floor_height(const Scenario& scenario) {
  const Collider* const plane = plane_of(scenario.model);
  return plane == nullptr ? 0 : dot(plane->normal, plane->point);
}

bool put_on_floor(Scenario& scenario) {
  Model model = scenario.model;
  const World world(model);
  const Vec3 up = up_of(model);
  const auto count = static_cast<std::size_t>(model.size());
  std::vector<std::vector<contact::Solid>> solids(count);
  for (const Collider& collider : model.colliders())
    if (collider.body != ground) solids[at(collider.body)].push_back(collider.solid);
  const std::vector<std::vector<Vec3>> lines = lines_of(model);

  double size = 0;  // of the largest mechanism
  for (const Mechanism& mechanism : world.mechanisms()) size = std::max(size, support_of(world, mechanism, solids, up).reach);
  if (!(size > 0)) size = 1;
  std::vector<BodyId> all, added;
  for (int b = 0; b < model.size(); ++b) {
    all.push_back({b});
    if (!solids[at({b})].empty()) continue;
    const Shape none;
    const Shape& shape = at({b}) < scenario.shapes.size() ? scenario.shapes[at({b})] : none;
    solids[at({b})] = solids_of(model[{b}], shape, lines[at({b})], size);
    if (solids[at({b})].empty()) continue;
    added.push_back({b});
    add_colliders({b}, solids[at({b})], model);
  }
  const bool own = plane_of(model) != nullptr;
  if (own && added.empty()) return false;

  double height = HUGE_VAL;
  std::vector<BodyId> standing;
  for (const Mechanism& mechanism : world.mechanisms()) {
    const Support how = support_of(world, mechanism, solids, up);
    size = std::max(size, how.reach);
    for (const BodyId b : mechanism.bodies)
      for (const contact::Solid& solid : solids[at(b)]) height = std::min(height, lowest(solid, world.motions()[at(b)].pose, up));
    if (mechanism.grounded && how.from_above()) height = std::min(height, how.height - how.reach);
    if (mechanism.grounded && !how.from_above()) standing.push_back(mechanism.root);
  }
  if (!added.empty()) pass_through(model, added, all);
  if (!own) {
    Collider plane;
    plane.plane = true, plane.normal = up;
    plane.point = (std::isfinite(height) ? height - room * size : 0) * up;
    model.add_collider(std::move(plane));
    ContactRule rule;
    rule.other = {ground};
    rule.law = {friction, friction, restitution, false};
    model.add_contact_rule(std::move(rule));
  }
  if (!standing.empty()) pass_through(model, standing, {ground});
  for (std::size_t i = 0; own && i < added.size(); ++i) {  // some may reach into a floor that was there
    const std::optional<Overlap> overlap = deepest_overlap(model);
    if (!overlap || !overlap->cable.empty()) break;
    const std::string& name = overlap->one == "ground" ? overlap->other : overlap->one;
    if (std::find(added.begin(), added.end(), model.body(name)) == added.end()) break;
    pass_through(model, {model.body(name)}, {ground});
  }
  scenario.model = std::move(model);
  Integration& integration = scenario.integration;
  if (!is_adaptive(integration.method)) integration.max_step = std::clamp(integration.step, shortest_flight, step);
  integration.method = contact_stepping_method();
  integration.step = step;
  return true;
}

}  // namespace momentree::io
