// Compiled with gear.patch: the element reaches the visitors, and its efforts are those of teeth that push and never pull.
#include <cmath>
#include <cstdio>
#include <string_view>

#include <momentree/model/elements/gear.hpp>
#include <momentree/model/joint_element.hpp>
#include <momentree/scenario/keys/described.hpp>

using namespace momentree;

namespace {

int failures = 0;
void check(bool holds, const char* what) {
  if (!holds) std::printf("wrong: %s\n", what), ++failures;
}

}  // namespace

int main() {
  const elements::Gear gear{{0}, {1}, -0.5, 0.1, 0.02, 1000, 2};
  const auto effort = [&](double apart, double rate, std::size_t on) {
    const double q[] = {0.1 + apart, 0}, v[] = {rate, 0};
    double efforts[2] = {};
    gear.efforts(q, v, efforts);
    return efforts[on];
  };
  check(effort(0.009, 1, 0) == 0 && effort(-0.009, -1, 0) == 0, "no force within the gap");
  check(std::fabs(effort(0.02, 1, 0) + 12) < 1e-9 && std::fabs(effort(-0.02, -1, 0) - 12) < 1e-9, "the teeth push");
  check(std::fabs(effort(0.02, 1, 1) + 6) < 1e-9, "the other gear is pushed by the ratio");
  check(effort(0.02, -100, 0) == 0, "they never pull");

  static_assert(has_table<elements::Gear> && std::variant_size_v<JointElement> == 3);
  int keys = 0;
  for (const io::Key& key : io::keys_of<elements::Gear>())
    keys += key.name == std::string_view("backlash") || key.name == std::string_view("follows");
  check(keys == 2, "the keys of [[gear]]");
  return failures;
}
