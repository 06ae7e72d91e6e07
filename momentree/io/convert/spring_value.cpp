#include <cmath>

#include <momentree/io/convert/describe.hpp>

namespace momentree::io {

using namespace document_values;

Value::Table describe_spring(const Spring& spring, const Model& model) {
  Value::Table table;
  add(table, "name", text(spring.name));
  const auto end = [&](const char* key, const SpringEnd& from) {
    Value::Table one;
    add(one, "body", text(from.body == ground ? "ground" : model[from.body].name));
    if (!(from.point == Vec3{})) add(one, "point", list(from.point));
    add(table, key, value(std::move(one)));
  };
  end("from", spring.from), end("to", spring.to);
  if (spring.inextensible) {
    if (spring.rest) add(table, "length", number(*spring.rest));
    if (spring.restitution != 0) add(table, "restitution", number(spring.restitution));
    if (std::isfinite(spring.strength)) add(table, "strength", number(spring.strength));
    return table;
  }
  add(table, "stiffness", number(spring.stiffness));
  if (spring.rest) add(table, "rest", number(*spring.rest));
  if (spring.damping != 0) add(table, "damping", number(spring.damping));
  if (spring.tension_only) add(table, "tension_only", Value(true, Place{}));
  if (std::isfinite(spring.strength)) add(table, "strength", number(spring.strength));
  return table;
}

Value::Table describe_coupling(const Coupling& coupling, const Model& model) {
  Value::Table table;
  add(table, "joint", text(model[coupling.joint].joint_name));
  if (coupling.leads()) add(table, "follows", text(model[coupling.follows].joint_name));
  const auto& a = coupling.higher;
  if (coupling.leads() && a != std::array<double, 3>{}) {
    Value::Array all;
    for (const double x : {coupling.offset, coupling.multiplier, a[0], a[1], a[2]}) all.push_back(number(x));
    add(table, "polynomial", value(std::move(all)));
    return table;
  }
  if (coupling.leads() && coupling.multiplier != 1) add(table, "multiplier", number(coupling.multiplier));
  if (coupling.offset != 0 || !coupling.leads()) add(table, "offset", number(coupling.offset));
  return table;
}

Value::Table describe_coupling(const JointCoupling& coupling, const Model& model) {
  Value::Table table;
  add(table, "joint", text(model[coupling.joint].joint_name));
  add(table, "follows", text(model[coupling.leader].joint_name));
  if (coupling.multiplier != 1) add(table, "multiplier", number(coupling.multiplier));
  if (coupling.offset != 0) add(table, "offset", number(coupling.offset));
  add(table, "stiffness", number(coupling.stiffness));
  if (coupling.damping != 0) add(table, "damping", number(coupling.damping));
  return table;
}

}  // namespace momentree::io
