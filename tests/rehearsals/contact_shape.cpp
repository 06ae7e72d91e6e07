// Compiled with contact_shape.patch: bodies of the new shape have mass, rest, slide, tip and touch others as they should.
#include <momentree/contact/shapes/distance.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>

#include "shape_checks.hpp"

using namespace momentree;

namespace {

const contact::RoundedBox shape{{0.4, 0.3, 0.8}, 0.05};
const double half_width = shape.size.x / 2 + shape.radius, half_height = shape.size.z / 2 + shape.radius;

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

void check_rest() {
  for (const char* method : {"dop853", "stepping"}) {
    Simulation sim(on_floor(shape, {{0, 0, half_height + 0.1}, {}}, 0.5), {.method = method, .step = 1e-3});
    check(bool(sim.run_until(0.5)), "a fall");
    check(near(sim.world().motions()[0].pose.position.z, half_height, 1e-9), std::string("height at rest, ") + method);
    check(norm(sim.world().motions()[0].linear) < 1e-9, std::string("rest, ") + method);
  }
}

void check_slide() {
  Simulation sim(on_floor(shape, {{0, 0, half_height}, {}}, 0.2, {1, 0, 0, 0, 0, 0}), {.method = "dop853"});
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
    const Model model = on_floor(shape, {{0, 0, height}, from_axis_angle({0, 1, 0}, angle)}, 1);
    Simulation sim(model, {.method = "stepping", .step = 1e-3});
    check(near(sim.world().gap(BodyId{0}, ground)->distance, 0, 1e-12), "gap of an edge");
    check(bool(sim.run_until(3)), "a fall from an edge");
    check(near(sim.world().motions()[0].pose.position.z, more < 0 ? half_height : half_width, 1e-4), "where it falls to");
  }
}

void check_pairs() {
  contact::each_primitive([](const auto& other) {
    check_pair(shape, half_height, other, -contact::distance_to_plane(contact::solid(other, {}), {}, {}, {0, 0, 1}).distance);
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
  return check(true, "");
}
