#pragma once
// The expressions of one step: its inputs by name, its outputs in sections, and comments where a part begins.
#include <string>
#include <vector>

#include <momentree/generate/symbolic.hpp>
#include <momentree/joint/derived_steps.hpp>

namespace momentree::derive {

using T = Symbolic<false>;

/// A number that a step writes: `to = prefix value;`.
struct Store {
  std::string to;
  int node = 0;
  std::string guard;  ///< a condition without which zero is stored
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
};

/// Records expressions while it exists.
class Recorder {
 public:
  Recorder() { T::graph() = &expressions; }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder() { T::graph() = nullptr; }

  /// A number of the state, or handed over from another body.
  T number(const std::string& name) { return input(Operation::q, name, numbers); }
  /// A constant of the link.
  T constant(const std::string& name) { return input(Operation::p, name, constants); }
  Vector3<T> numbers_of(const std::string& name) { return {number(name + ".x"), number(name + ".y"), number(name + ".z")}; }
  Vector3<T> constants_of(const std::string& name) {
    return {constant(name + ".x"), constant(name + ".y"), constant(name + ".z")};
  }
  /// Gives a product of constants that the link stores a name.
  void known(T value, const std::string& name) { names.emplace_back(value.node(), name); }
  int size() const { return static_cast<int>(expressions.nodes().size()); }

  Expressions expressions;
  std::vector<std::string> numbers, constants;
  std::vector<std::pair<int, std::string>> names;

 private:
  T input(Operation array, const std::string& name, std::vector<std::string>& all) {
    all.push_back(name);
    return T::of_node(expressions.input(array, static_cast<int>(all.size()) - 1));
  }
};

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

  Link(Recorder& in, LinkRotation rotation)
      : cos_a(rotation > LinkRotation::tilted ? T(1) : in.constant("k.cos_a")),
        sin_a(rotation > LinkRotation::tilted ? T(0) : in.constant("k.sin_a")),
        cos_b(rotation > LinkRotation::any ? T(1) : in.constant("k.cos_b")),
        sin_b(rotation > LinkRotation::any ? T(0) : in.constant("k.sin_b")),
        cos_0(in.constant("k.cos_0")),
        sin_0(in.constant("k.sin_0")),
        R0{T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)},
        r(in.constants_of("k.r")),
        body{in.constant("k.body.m"),
             in.constants_of("k.body.mc"),
             {in.constant("k.body.J.xx"), in.constant("k.body.J.yy"), in.constant("k.body.J.zz"), in.constant("k.body.J.xy"),
              in.constant("k.body.J.xz"), in.constant("k.body.J.yz")}},
        geometry{in.constant("k.geometry[0]"), in.constant("k.geometry[1]"), in.constant("k.geometry[2]")} {
    if (rotation <= LinkRotation::tilted) in.known(cos_a * sin_a, "k.cs_a"), in.known(sin_a * sin_a, "k.ss_a");
    if (rotation == LinkRotation::none) return;
    if (rotation == LinkRotation::about_z) {
      R0.xx = R0.yy = cos_0, R0.xy = -sin_0, R0.yx = sin_0;
      return;
    }
    R0 = {in.constant("k.R0.xx"), in.constant("k.R0.xy"), in.constant("k.R0.xz"), in.constant("k.R0.yx"), in.constant("k.R0.yy"),
          in.constant("k.R0.yz"), in.constant("k.R0.zx"), in.constant("k.R0.zy"), in.constant("k.R0.zz")};
  }
};

}  // namespace momentree::derive
