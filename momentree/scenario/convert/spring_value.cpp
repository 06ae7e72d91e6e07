#include <algorithm>
#include <string_view>
#include <utility>

#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/keys/described.hpp>

namespace momentree::io {

using namespace document_values;

Value::Table describe_spring(const Spring& spring, const Model& model) {
  TableWriter writer(model);
  return spring.inextensible ? writer.of(cable_of(spring)) : writer.of(spring);
}

namespace {

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

}  // namespace

Value::Array describe_couplings(const Model& model) {
  Value::Array all;
  for (const JointElement& element : model.elements())
    if (const auto* const spring = std::get_if<elements::SpringCoupling>(&element))
      all.push_back(value(TableWriter(model).of(*spring)));
  for (const Coupling& each : model.couplings()) all.push_back(value(describe_coupling(each, model)));
  return all;
}

std::vector<std::pair<const char*, Value::Array>> describe_elements(const Model& model) {
  std::vector<std::pair<const char*, Value::Array>> all;
  for (const JointElement& element : model.elements())
    with_kind(element, [&](const auto& kind) {
      using T = std::decay_t<decltype(kind)>;
      if constexpr (has_table<T>) {
        const auto known =
            std::find_if(all.begin(), all.end(), [](const auto& list) { return std::string_view(list.first) == T::info.key; });
        auto& list = known == all.end() ? all.emplace_back(T::info.key, Value::Array()) : *known;
        list.second.push_back(value(TableWriter(model).of(kind)));
      }
    });
  return all;
}

}  // namespace momentree::io
