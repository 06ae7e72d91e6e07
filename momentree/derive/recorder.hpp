#pragma once
// The expressions of one step: its inputs by name, its outputs in sections, and comments where a part begins.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <momentree/derive/symbolic.hpp>
#include <momentree/joint/placement_shapes.hpp>

namespace momentree::derive {

using T = Symbolic;

/// A number that a step writes: `to = prefix value;`.
struct Store {
  std::string to;
  int node = 0;
};
struct Comment {
  int before = 0;  ///< the first node of the part
  std::string text;
};

/// One function: what it stores, and `last` what it stores where inputs may be; what it computes first, because much waits for
/// it.
struct Function {
  std::vector<int> first;
  std::vector<Store> stores, last;
  std::vector<Comment> comments;
  int end = 0;  ///< the first node that is not its own
};

/// The functions of a step in the order in which they run. `record`: the nodes that one of them stores for later ones.
struct Derived {
  std::vector<Function> functions;
  std::vector<int> record;

  /// The function in which a node was first computed.
  std::size_t owner(int node) const {
    std::size_t i = 0;
    while (node >= functions[i].end) ++i;
    return i;
  }
  void find_record(const std::vector<Expressions::Node>& nodes, const std::vector<std::string>& numbers);
};

/// A function reads from the record what it needs of the operations of those before it, and of numbers that are theirs alone.
inline void Derived::find_record(const std::vector<Expressions::Node>& nodes, const std::vector<std::string>& numbers) {
  const auto lasts = [&](const Expressions::Node& node) {
    if (node.operation != Operation::q) return !binary(node.operation);
    const std::string& name = numbers[static_cast<std::size_t>(node.a)];
    return name.starts_with("j.") || name.starts_with("w.") || name.starts_with("p[");
  };
  std::vector<bool> recorded(nodes.size(), false);
  for (std::size_t f = functions.size(); f-- > 0;) {
    const int begin = f == 0 ? 0 : functions[f - 1].end;
    std::vector<bool> needed(nodes.size(), false);
    for (const auto* list : {&functions[f].stores, &functions[f].last})
      for (const Store& one : *list) needed[static_cast<std::size_t>(one.node)] = true;
    for (std::size_t i = nodes.size(); i-- > 0;) {
      const auto& node = nodes[i];
      if (recorded[i] && static_cast<int>(i) >= begin && static_cast<int>(i) < functions[f].end) needed[i] = true;
      if (!needed[i]) continue;
      if (!lasts(node) && static_cast<int>(i) < begin) {
        recorded[i] = true;
        continue;
      }
      if (unary(node.operation) || binary(node.operation)) needed[static_cast<std::size_t>(node.a)] = true;
      if (binary(node.operation)) needed[static_cast<std::size_t>(node.b)] = true;
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (recorded[i]) record.push_back(static_cast<int>(i));
}

/// Records expressions while it exists.
class Recorder {
 public:
  Recorder() { T::graph() = &expressions; }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder() { T::graph() = nullptr; }

  /// A number of the state, or handed over from another body.
  T number(const std::string& name) { return input(Operation::q, name, numbers); }
  /// A constant of the link; a number if its value is known.
  T constant(const std::string& name) {
    if (const std::optional<double> value = known_value ? known_value(name) : std::nullopt) return T(*value);
    return input(Operation::p, name, constants);
  }
  Vector3<T> numbers_of(const std::string& name) { return {number(name + ".x"), number(name + ".y"), number(name + ".z")}; }
  Vector3<T> constants_of(const std::string& name) {
    return {constant(name + ".x"), constant(name + ".y"), constant(name + ".z")};
  }
  int size() const { return static_cast<int>(expressions.nodes().size()); }

  std::function<std::optional<double>(const std::string&)> known_value{};
  Expressions expressions;
  std::vector<std::string> numbers, constants;

 private:
  T input(Operation array, const std::string& name, std::vector<std::string>& all) {
    all.push_back(name);
    return T::of_node(expressions.input(array, static_cast<int>(all.size()) - 1));
  }
};

/// The place of a body in its mechanism, by what its steps can omit: the children of a leaf, the parent of a root.
enum class BodyPlace : unsigned char { inner, leaf, root, single };

/// The constants of a link as symbols.
struct Link {
  struct Body {
    T m;
    Vector3<T> mc;
    Symmetric3<T> J;
  };
  T cos_a, sin_a, cos_b, sin_b, cos_0, sin_0;
  Matrix3<T> R0;
  Vector3<T> r;
  Body body;
  T geometry[3];
  T d{0};  ///< offset along the joint's axis, if the shape has it: apart from r
  static constexpr bool d_apart = true;

  /// `shape`: of the placement, for kinds that are placed by it.
  Link(Recorder& in, std::optional<PlacementShape> shape) : Link(in) {
    if (!shape) return;
    dispatch_shape(*shape, [&](auto is) {
      using Has = PlacementTerms<is()>;
      if (!Has::any_offset) r = {Has::a ? r.x : T(0), T(0), T(0)}, d = Has::d ? in.constant("k.d") : T(0);
      if (Has::right) cos_a = T(0), sin_a = T(1);
    });
  }

 private:
  explicit Link(Recorder& in)
      : cos_a(in.constant("k.cos_a")),
        sin_a(in.constant("k.sin_a")),
        cos_b(in.constant("k.cos_b")),
        sin_b(in.constant("k.sin_b")),
        cos_0(in.constant("k.cos_0")),
        sin_0(in.constant("k.sin_0")),
        R0{in.constant("k.R0.xx"), in.constant("k.R0.xy"), in.constant("k.R0.xz"), in.constant("k.R0.yx"), in.constant("k.R0.yy"),
           in.constant("k.R0.yz"), in.constant("k.R0.zx"), in.constant("k.R0.zy"), in.constant("k.R0.zz")},
        r(in.constants_of("k.r")),
        body{in.constant("k.body.m"),
             in.constants_of("k.body.mc"),
             {in.constant("k.body.J.xx"), in.constant("k.body.J.yy"), in.constant("k.body.J.zz"), in.constant("k.body.J.xy"),
              in.constant("k.body.J.xz"), in.constant("k.body.J.yz")}},
        geometry{in.constant("k.geometry[0]"), in.constant("k.geometry[1]"), in.constant("k.geometry[2]")} {}
};

}  // namespace momentree::derive
