#include <momentree/derive/step.hpp>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <string>
#include <string_view>

#include <momentree/derive/kept_steps.hpp>
#include <momentree/derive/momentum_steps.hpp>
#include <momentree/derive/velocity_steps.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree::derive {

namespace {

struct LinkNumber {
  const char* name;
  std::size_t offset;
};
constexpr LinkNumber all_link_numbers[] = {
#define MOMENTREE_LINK_NUMBER(x) {"k." #x, offsetof(LinkConstants, x)},
    MOMENTREE_LINK_NUMBER(cos_a) MOMENTREE_LINK_NUMBER(sin_a) MOMENTREE_LINK_NUMBER(cos_b) MOMENTREE_LINK_NUMBER(sin_b)
        MOMENTREE_LINK_NUMBER(cos_0) MOMENTREE_LINK_NUMBER(sin_0) MOMENTREE_LINK_NUMBER(d) MOMENTREE_LINK_NUMBER(r.x)
            MOMENTREE_LINK_NUMBER(r.y) MOMENTREE_LINK_NUMBER(r.z) MOMENTREE_LINK_NUMBER(body.m) MOMENTREE_LINK_NUMBER(body.mc.x)
                MOMENTREE_LINK_NUMBER(body.mc.y) MOMENTREE_LINK_NUMBER(body.mc.z) MOMENTREE_LINK_NUMBER(body.J.xx)
                    MOMENTREE_LINK_NUMBER(body.J.yy) MOMENTREE_LINK_NUMBER(body.J.zz) MOMENTREE_LINK_NUMBER(body.J.xy)
                        MOMENTREE_LINK_NUMBER(body.J.xz) MOMENTREE_LINK_NUMBER(body.J.yz) MOMENTREE_LINK_NUMBER(R0.xx)
                            MOMENTREE_LINK_NUMBER(R0.xy) MOMENTREE_LINK_NUMBER(R0.xz) MOMENTREE_LINK_NUMBER(R0.yx)
                                MOMENTREE_LINK_NUMBER(R0.yy) MOMENTREE_LINK_NUMBER(R0.yz) MOMENTREE_LINK_NUMBER(R0.zx)
                                    MOMENTREE_LINK_NUMBER(R0.zy) MOMENTREE_LINK_NUMBER(R0.zz) MOMENTREE_LINK_NUMBER(geometry[0])
                                        MOMENTREE_LINK_NUMBER(geometry[1]) MOMENTREE_LINK_NUMBER(geometry[2])
#undef MOMENTREE_LINK_NUMBER
};
constexpr std::size_t link_numbers = std::size(all_link_numbers);
// What LinkNumbers takes as two blocks.
constexpr std::size_t placement_and_body = 0, angle_and_geometry = offsetof(LinkConstants, cos_0);
static_assert(offsetof(LinkConstants, cos_a) == 0 && offsetof(LinkConstants, R0) + sizeof(Mat3) == 29 * sizeof(double) &&
              offsetof(LinkConstants, geometry) + 3 * sizeof(double) == angle_and_geometry + 6 * sizeof(double));
double number_of(const LinkNumbers& numbers, std::size_t i) {
  const std::size_t offset = all_link_numbers[i].offset;
  return offset < angle_and_geometry ? numbers.placement_and_body[offset / sizeof(double)]
                                     : numbers.angle_and_geometry[(offset - angle_and_geometry) / sizeof(double)];
}

std::size_t link_number(std::string_view name) {
  const auto found = std::ranges::find(all_link_numbers, name, &LinkNumber::name);
  MT_REQUIRE(found != std::end(all_link_numbers), "a number of the link");
  return static_cast<std::size_t>(found - all_link_numbers);
}

// Two bits per number: 0, 1, −1, or any other value.
constexpr double known_values[] = {0, 1, -1};
constexpr std::uint64_t any_value = 3;
std::uint64_t code_in(const StepKey& key, std::size_t i) { return key.pattern[i / 32] >> 2 * (i % 32) & 3; }

/// What the derivation needs to know of kernels besides their functions.
template <class K>
Traits traits_of(const StepKey& key) {
  Traits traits{info(key.kind).name};
  if constexpr (!K::rotates_about_z && !K::angles.empty())  // the last rotation is about z
    traits.angle = static_cast<int>(K::angles.size()) - 1, traits.dof = K::angles.back();
  if constexpr (K::placed_by_shape) traits.frame = Order::before_displacement;
  traits.armature = key.armature;
  return traits;
}

/// The operations of all passes that are not on constants alone: a measure of their time.
int operations(const Recorder& in, const Derived& steps) {
  const auto& nodes = in.expressions.nodes();
  std::vector<char> varies(nodes.size(), 0);
  int count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& n = nodes[i];
    const auto of = [&](int operand) { return varies[static_cast<std::size_t>(operand)] != 0; };
    varies[i] = n.operation == Operation::q || (unary(n.operation) && of(n.a)) || (binary(n.operation) && (of(n.a) || of(n.b)));
  }
  std::vector<int> results;
  for (const Function& f : steps.functions)
    for (const auto* list : {&f.stores, &f.last})
      for (const Store& one : *list) results.push_back(one.node);
  const std::vector<bool> needed = in.expressions.needed(results);
  for (std::size_t i = 0; i < nodes.size(); ++i) count += needed[i] && varies[i] && binary(nodes[i].operation);
  return count;
}

struct Recorded {
  std::unique_ptr<Recorder> in;
  Derived steps;
};

template <class K, std::size_t NQ, std::size_t NV>
Recorded record_step(const StepKey& key) {
  const Traits traits = traits_of<K>(key);
  const std::optional<PlacementShape> shape = K::placed_by_shape ? std::optional(key.shape) : std::nullopt;
  Recorded least;
  int fewest = 0;
  std::vector<Order> orders;
  if (!K::rotates_about_z || keeps_results(key.passes)) orders.push_back({});
  for (const Order::Frame frame : {Order::child, Order::before_rotation, Order::before_displacement})
    for (const bool one_shift : {false, true})
      if (K::rotates_about_z && !keeps_results(key.passes) && (key.fewest || frame == traits.frame))
        if (!one_shift || frame != Order::before_displacement) orders.push_back({frame, one_shift});
  for (const Order& order : orders) {
    Recorded other{std::make_unique<Recorder>(), {}};
    other.in->known_value = [&key](const std::string& name) -> std::optional<double> {
      if (name == "mass" || name == "armature") return {};
      const std::uint64_t code = code_in(key, link_number(name));
      if (code == any_value) return {};
      return known_values[code];
    };
    if (keeps_results(key.passes))
      other.steps = KeptSteps<K, NQ, NV>(shape, key.place, key.gravity, key.armature, *other.in).run(key.passes);
    else if (key.passes == Passes::stage_momenta)
      other.steps = MomentumSteps<K, NQ, NV>(traits, shape, key.place, order, *other.in, key.gravity).run();
    else
      other.steps = VelocitySteps<K, NQ, NV>(traits, shape, key.place, order, *other.in).run();
    const int count = operations(*other.in, other.steps);
    if (least.in == nullptr || count < fewest) least = std::move(other), fewest = count;
  }
  least.in->known_value = {};
  return least;
}

Recorded record_step(const StepKey& key) {
  return dispatch(key.kind, [&](auto tag) -> Recorded {
    using K = typename decltype(tag)::type;
    constexpr auto nq = static_cast<std::size_t>(K::info.nq), nv = static_cast<std::size_t>(K::info.nv);
    if constexpr (nv == 0) {
      MT_REQUIRE(false, "welds have no steps");
      return {};
    } else {
      if constexpr (requires { typename K::Generic; })
        if (key.armature) return record_step<typename K::Generic, nq, nv>(key);
      return record_step<typename K::Kernels, nq, nv>(key);
    }
  });
}

}  // namespace

LinkNumbers numbers_of(const LinkConstants& link) {
  LinkNumbers all;
  const auto* const memory = reinterpret_cast<const char*>(&link);
  std::memcpy(all.placement_and_body.data(), memory + placement_and_body, sizeof all.placement_and_body);
  std::memcpy(all.angle_and_geometry.data(), memory + angle_and_geometry, sizeof all.angle_and_geometry);
  return all;
}

bool same_numbers(const LinkNumbers& numbers, const LinkConstants& link) {
  const auto* const memory = reinterpret_cast<const char*>(&link);
  return std::memcmp(numbers.placement_and_body.data(), memory + placement_and_body, sizeof numbers.placement_and_body) == 0 &&
         std::memcmp(numbers.angle_and_geometry.data(), memory + angle_and_geometry, sizeof numbers.angle_and_geometry) == 0;
}

StepKey key_of(Kind kind, bool armature, BodyPlace place, const LinkConstants& link) {
  const bool by_shape = dispatch(kind, [](auto tag) { return decltype(tag)::type::Kernels::placed_by_shape; });
  const bool has_parent = place == BodyPlace::inner || place == BodyPlace::leaf;  // the placement of a root is used once
  return {
      .kind = kind, .armature = armature, .place = place, .shape = by_shape && has_parent ? link.shape : PlacementShape::general};
}

bool has_steps(Kind kind, Variant variant) {
  const bool own_axis = dispatch(kind, [](auto tag) {
    using K = typename decltype(tag)::type;
    return K::info.nv == 1 && requires { typename K::Generic; };  // E is a unit vector
  });
  return info(kind).nv > 0 && (variant == Variant::plain || (variant == Variant::armature && own_axis));
}

void add_pattern(const LinkNumbers& numbers, StepKey& key) {
  for (std::size_t i = 0; i < link_numbers; ++i) {
    const auto* const known = std::ranges::find(known_values, number_of(numbers, i));
    const auto code = static_cast<std::uint64_t>(known - known_values);
    key.pattern[i / 32] |= code << 2 * (i % 32);
  }
}

void add_general_pattern(StepKey& key) { key.pattern.fill(~std::uint64_t{0}); }

bool is_general(const StepKey& key) {
  StepKey general = key;
  add_general_pattern(general);
  return key == general;
}

Step::Step(const StepKey& key) : kind_(key.passes) {
  Expressions* const outer = T::graph();  // this may happen while something else is recorded
  Recorded recorded = record_step(key);
  in_ = std::move(recorded.in), steps_ = std::move(recorded.steps);
  T::graph() = outer;
  if (in_->expressions.exhausted()) throw std::bad_alloc();
  in_->expressions.end();
  if (key.passes == Passes::stage_momenta && key.gravity) mass_ = 1, moments_ = 3;
  find_levels();
  find_constants();
}

void Step::find_levels() {
  const auto& nodes = in_->expressions.nodes();
  levels_.assign(nodes.size(), Level::state);
  const auto of = [&](int i) { return levels_[static_cast<std::size_t>(i)]; };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& n = nodes[i];
    const auto is = [&](const char* name) { return in_->constants[static_cast<std::size_t>(n.a)] == name; };
    if (n.operation == Operation::constant)
      levels_[i] = Level::number;
    else if (n.operation == Operation::p && !is("armature") && !is("mass"))
      levels_[i] = Level::link;  // methods may change armatures at any time
    else if (unary(n.operation))
      levels_[i] = of(n.a);
    else if (binary(n.operation))
      levels_[i] = std::max(of(n.a), of(n.b));
  }
  place_.assign(nodes.size(), -1);
  for (const int node : steps_.record)
    if (of(node) == Level::state) {
      place_[static_cast<std::size_t>(node)] = mass_ + static_cast<int>(record_.size());
      record_.push_back(node);
    }
}

/// The constants that the passes read, and the operations that find them from the link's.
void Step::find_constants() {
  const auto& nodes = in_->expressions.nodes();
  constant_slot_.assign(nodes.size(), -1);
  std::vector<char> read(nodes.size(), 0);
  const auto reads = [&](int i) {
    if (levels_[static_cast<std::size_t>(i)] == Level::link) read[static_cast<std::size_t>(i)] = 1;
  };
  std::vector<int> stored;
  for (const Function& f : steps_.functions)
    for (const auto* list : {&f.stores, &f.last})
      for (const Store& one : *list) reads(one.node), stored.push_back(one.node);
  const std::vector<bool> used = in_->expressions.needed(stored);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!used[i] || levels_[i] != Level::state) continue;
    if (unary(nodes[i].operation) || binary(nodes[i].operation)) reads(nodes[i].a);
    if (binary(nodes[i].operation)) reads(nodes[i].b);
  }
  std::vector<int> results;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (read[i]) constant_slot_[i] = static_cast<int>(results.size()), results.push_back(static_cast<int>(i));
  const std::vector<bool> needed = in_->expressions.needed(results);
  std::vector<int> at(nodes.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!needed[i] || levels_[i] == Level::state) continue;
    const auto& n = nodes[i];
    Constant one{n.operation, 0, 0, n.value};
    if (n.operation == Operation::p) one.a = static_cast<int>(link_number(in_->constants[static_cast<std::size_t>(n.a)]));
    if (unary(n.operation) || binary(n.operation)) one.a = at[static_cast<std::size_t>(n.a)];
    if (binary(n.operation)) one.b = at[static_cast<std::size_t>(n.b)];
    at[i] = static_cast<int>(program_.size());
    program_.push_back(one);
  }
  for (const int node : results) constants_.push_back(at[static_cast<std::size_t>(node)]);
}

void Step::evaluate_constants(const LinkNumbers& link, double* to) const {
  std::array<double, 512> x;
  x[0] = 0;
  MT_REQUIRE(program_.size() <= x.size(), "constants follow from the link's in few operations");
  for (std::size_t i = 0; i < program_.size(); ++i) {
    const Constant& one = program_[i];
    const double a = x[static_cast<std::size_t>(one.operation == Operation::p ? 0 : one.a)],
                 b = x[static_cast<std::size_t>(one.b)];
    switch (one.operation) {
      case Operation::constant: x[i] = one.value; break;
      case Operation::p: x[i] = number_of(link, static_cast<std::size_t>(one.a)); break;
      case Operation::negative: x[i] = -a; break;
      case Operation::sum: x[i] = a + b; break;
      case Operation::difference: x[i] = a - b; break;
      case Operation::product: x[i] = a * b; break;
      default: x[i] = a / b; break;
    }
  }
  for (std::size_t k = 0; k < constants_.size(); ++k) to[k] = x[static_cast<std::size_t>(constants_[k])];
}

}  // namespace momentree::derive
