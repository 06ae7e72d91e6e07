#include <momentree/results/columns/energy_columns.hpp>

#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

/// Zero at the world's origin, as in Totals (J).
double gravity_energy(const World& world) {
  const Model& model = world.model();
  double energy = 0;
  for (int b = 0; b < model.size(); ++b) {
    if (!world.alive({b})) continue;
    const BodySpec& body = model[BodyId{b}];
    const Pose& pose = world.motions()[static_cast<std::size_t>(b)].pose;
    energy -= body.mass * dot(model.gravity(), pose * body.com);
  }
  return energy;
}

}  // namespace

std::vector<std::string> energy_column_names() {
  std::vector<std::string> names = {"kinetic", "gravity", "elastic", "dissipated", "lost", "released", "work", "error"};
  for (const char* momentum : {"linear", "angular"})
    for (const char* axis : {".x", ".y", ".z"}) names.push_back(std::string(momentum) + axis);
  return names;
}

std::array<double, 14> energy_numbers(const World& world, const EnergyBalance& balance) {
  const Totals totals = world.totals();
  const double gravity = gravity_energy(world);
  return {totals.kinetic,
          gravity,
          totals.potential - gravity,
          balance.dissipated,
          balance.lost_in_impacts,
          balance.released,
          balance.work,
          balance.error,
          totals.linear.x,
          totals.linear.y,
          totals.linear.z,
          totals.angular.x,
          totals.angular.y,
          totals.angular.z};
}

void energy_header(std::string& text) {
  text += "time";
  for (const std::string& name : energy_column_names()) text += ',' + name;
  text += '\n';
}

void energy_row(std::string& text, const World& world, const EnergyBalance& balance) {
  append_number(text, world.time());
  for (const double x : energy_numbers(world, balance)) {
    text += ',';
    append_number(text, x);
  }
  text += '\n';
}

}  // namespace momentree::io
