#include <momentree/scenario/keys/joint_keys.hpp>

#include <limits>
#include <string>

#include <doctest/doctest.h>

#include <momentree/scenario/keys/fields.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <momentree/scenario/state/parameters_json.hpp>
#include <momentree/scenario/test_support.hpp>

namespace momentree::io {
namespace {

// A table with 0.5 for every key, except restitution and rest_speed, which soft stops lack, and motion, which excludes others.
Value table_of(std::span<const JointKey> keys) {
  Value::Table table;
  for (const JointKey& key : keys) {
    const std::string name = key.key;
    if (key.documents || key.one_dof || name == "restitution" || name == "rest_speed") continue;
    Value value(0.5, Place{});
    if (const auto* group = std::get_if<JointGroup>(&key.value)) value = table_of(group->keys);
    table.push_back({name, Place{}, std::move(value)});
  }
  return Value(std::move(table), Place{});
}

TEST_CASE("every key of a scenario sets its own parameter") {
  const Value table = table_of(joint_keys());
  Diagnostics out("s.toml", "");
  Fields fields(table, "joint", out);
  JointParameters read;
  read_parameters(fields, &info(Kind::revolute), read, out);
  fields.finish();
  CHECK(rendered(out.take()) == "");
  JointSettings settings(read), none;
  int set = 0, all = 0;
  const auto count = [&](std::span<const JointKey> keys, const auto& self) -> void {
    for (const JointKey& key : keys) {
      if (const auto* group = std::get_if<JointGroup>(&key.value))
        self(group->keys, self);
      else
        ++all, set += !alike({&key, 1}, settings, none, [](const auto& a, const auto& b) { return a == b; });
    }
  };
  count(joint_keys(), count);
  CHECK(set == all - 4);  // the effort of the drive is constant: that is the other effort
}

TEST_CASE("a parameter that is unlike the default is unlike it in some key") {
  const JointSettings none;
  const auto differs = [](JointParameters parameters) {
    JointSettings a(parameters), b;
    const bool same = alike(joint_keys(), a, b, [](const auto& x, const auto& y) { return x == y; });
    CHECK(a.packed() == parameters);
    return !same;
  };
  JointParameters p;
  CHECK_FALSE(differs(p));
  p.strength.torque = 3;
  CHECK(differs(p));
  p = {}, p.limits.rest_speed = 1;
  CHECK(differs(p));
  p = {}, p.drive = motion_drive(Signal::sine(1, 2));
  CHECK(differs(p));
  p = {}, p.drive = pd_drive({.kp = 1, .max_effort = std::numeric_limits<double>::infinity()});
  CHECK(differs(p));
}

}  // namespace
}  // namespace momentree::io
