// Compiled with contact_shape.patch: the new shape is described, and bodies of it move as they should.
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

#include <momentree/contact/primitive.hpp>
#include <momentree/contact/shapes/distance.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;
const contact::RoundedBox shape{{0.4, 0.3, 0.8}, 0.05};
const double half_width = shape.size.x / 2 + shape.radius, half_height = shape.size.z / 2 + shape.radius;

int failures = 0;
void check(bool holds, const std::string& what) {
  if (!holds) std::printf("wrong: %s\n", what.c_str()), ++failures;
}
bool near(double a, double b, double tolerance) { return std::fabs(a - b) <= tolerance; }

// ∫ dV and ∫ x² dV by points of a grid.
void check_uniform() {
  constexpr int n = 150;
  const Vec3 half = 0.5 * shape.size;
  const double reach = half.z + shape.radius, step = 2 * reach / n;
  double volume = 0;
  Vec3 squares{};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Vec3 p{(i + 0.5) * step - reach, (j + 0.5) * step - reach, (k + 0.5) * step - reach};
        const Vec3 beyond{std::fmax(std::fabs(p.x) - half.x, 0), std::fmax(std::fabs(p.y) - half.y, 0),
                          std::fmax(std::fabs(p.z) - half.z, 0)};
        if (norm(beyond) > shape.radius) continue;
        volume += step * step * step;
        squares += step * step * step * Vec3{p.x * p.x, p.y * p.y, p.z * p.z};
      }
  const contact::UniformBody body = shape.uniform();
  check(near(body.volume, volume, 3e-3 * volume), "volume");
  check(near(body.moments.x, squares.y + squares.z, 5e-3 * body.moments.x), "moment of inertia about x");
  check(near(body.moments.y, squares.z + squares.x, 5e-3 * body.moments.y), "moment of inertia about y");
  check(near(body.moments.z, squares.x + squares.y, 5e-3 * body.moments.z), "moment of inertia about z");
}

BodySpec body_of(const contact::Primitive& primitive, const char* name, const Pose& at) {
  constexpr double density = 800;
  const contact::UniformBody uniform = contact::uniform(primitive);
  const Vec3 I = density * uniform.moments;
  const Quat& r = at.rotation;
  return {.name = name,
          .mass = density * uniform.volume,
          .inertia = diagonal(I.x, I.y, I.z),
          .joint = Free{},
          .q = {at.position.x, at.position.y, at.position.z, r.w, r.x, r.y, r.z}};
}

Model on_floor(const Pose& at, double friction) {
  Model model({.gravity = {0, 0, -g}});
  const BodyId body = model.add(body_of(shape, "box/box", at));
  model.add_collider({.body = body, .solid = shape.solid({})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  return model;
}

void check_rest() {
  for (const char* method : {"dop853", "stepping"}) {
    Simulation sim(on_floor({{0, 0, half_height + 0.1}, {}}, 0.5), {.method = method, .step = 1e-3});
    check(bool(sim.run_until(0.5)), "a fall");
    check(near(sim.world().motions()[0].pose.position.z, half_height, 1e-9), std::string("height at rest, ") + method);
    check(norm(sim.world().motions()[0].linear) < 1e-9, std::string("rest, ") + method);
  }
}

void check_slide() {
  BodySpec spec = body_of(shape, "box/box", {{0, 0, half_height}, {}});
  spec.v = {1, 0, 0, 0, 0, 0};
  Model model({.gravity = {0, 0, -g}});
  const BodyId body = model.add(spec);
  model.add_collider({.body = body, .solid = shape.solid({})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 0.2, .static_friction = 0.2}});
  Simulation sim(model, {.method = "dop853"});
  check(bool(sim.run_until(0.3)), "a slide");
  const BodyMotion motion = sim.world().motions()[0];
  check(near(motion.linear.x, 1 - 0.2 * g * 0.3, 1e-7), "sliding friction");
  check(near(motion.pose.position.x, 0.3 - 0.1 * g * 0.09, 1e-7), "way of a slide");
  check(norm(motion.angular) < 1e-7, "a slide without a turn");
}

// On an edge it falls to the side of its centre of mass: the centre of the rounding is above the contact.
void check_tip() {
  const double critical = std::atan2(shape.size.x, shape.size.z);
  for (const double more : {-0.05, 0.05}) {
    const double angle = critical + more;
    const double height = shape.radius + std::cos(angle) * shape.size.z / 2 + std::sin(angle) * shape.size.x / 2;
    Simulation sim(on_floor({{0, 0, height}, from_axis_angle({0, 1, 0}, angle)}, 1), {.method = "stepping", .step = 1e-3});
    check(near(sim.world().gap(BodyId{0}, ground)->distance, 0, 1e-12), "gap of an edge");
    check(bool(sim.run_until(3)), "a fall from an edge");
    check(near(sim.world().motions()[0].pose.position.z, more < 0 ? half_height : half_width, 1e-4), "where it falls to");
  }
}

// Other shapes above it: their distance, and where they come to rest.
void check_pairs() {
  contact::each_primitive([](auto other) {
    const double below = -contact::distance_to_plane(other.solid({}), {}, {}, {0, 0, 1}).distance, gap = 0.1;
    const std::string name = other.info.key;
    Model model({.gravity = {0, 0, -g}});
    const BodyId base = model.add({.name = "base/base", .mass = 1, .inertia = diagonal(1), .joint = Weld{}});
    const BodyId top = model.add(body_of(other, "top/top", {{0, 0, half_height + gap + below}, {}}));
    model.add_collider({.body = base, .solid = shape.solid({})});
    model.add_collider({.body = top, .solid = other.solid({})});
    const World world(model);
    check(near(world.gap(base, top)->distance, gap, 1e-12), "distance from a " + name);
    for (const char* method : {"dop853", "stepping"}) {
      Simulation sim(model, {.method = method, .step = 1e-3});
      check(bool(sim.run_until(0.3)), "a " + name + " falls on it");
      check(near(sim.world().motions()[1].pose.position.z, half_height + below, 1e-8), "height of a " + name + " on it");
    }
  });
}

void check_documents() {
  int keys = 0;
  for (const io::Key& key : io::keys_of<contact::RoundedBox>())
    keys += key.name == std::string_view("size") || key.name == std::string_view("radius") ? 1 : 0;
  check(keys == 2, "keys");
  const Pose at{{1, 2, 3}, from_rpy(0.1, 0.2, 0.3)};
  const auto placed = contact::RoundedBox::from(shape.solid(at));
  check(placed && norm(placed->shape.size - shape.size) < 1e-14 && placed->shape.radius == shape.radius &&
            norm(placed->at.position - at.position) < 1e-14,
        "the shape of a collider");
  const io::MeshPart surface = io::surface_of(shape.solid({}));
  Vec3 most{};
  for (const Vec3& p : surface.points) most = {std::fmax(most.x, p.x), std::fmax(most.y, p.y), std::fmax(most.z, p.z)};
  check(norm(most - Vec3{half_width, shape.size.y / 2 + shape.radius, half_height}) < 1e-12, "triangles");
}

}  // namespace

int main() {
  check_uniform();
  check_rest();
  check_slide();
  check_tip();
  check_pairs();
  check_documents();
  return failures;
}
