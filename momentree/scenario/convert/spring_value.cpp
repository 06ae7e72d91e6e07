#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/keys/described.hpp>

namespace momentree::io {

using namespace document_values;

Value::Table describe_spring(const Spring& spring, const Model& model) {
  TableWriter writer(model);
  return spring.inextensible ? writer.of(cable_of(spring)) : writer.of(spring);
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
