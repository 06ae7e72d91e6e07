#pragma once
// The passes that keep what others read of each body, recorded from their own text (body_passes.hpp). Each reads what the passes
// before it left in the arrays.
#include <momentree/derive/recorder.hpp>
#include <momentree/derive/step_arguments.hpp>
#include <momentree/joint/body_passes.hpp>

namespace momentree::derive {

/// For kernels that ask for it; `R0` contains it.
inline const Matrix3<T>& placement_rotation(const Link& link) { return link.R0; }

template <class K, std::size_t NQ, std::size_t NV>
class KeptSteps {
 public:
  KeptSteps(std::optional<PlacementShape> shape, BodyPlace place, bool gravity, bool armature, Recorder& recorder)
      : leaf_(place == BodyPlace::leaf || place == BodyPlace::single),
        root_(place == BodyPlace::root || place == BodyPlace::single),
        gravity_(gravity),
        has_armature_(armature),
        in_(recorder),
        link_(recorder, shape) {}

  Derived run(Passes passes) {
    if (passes == Passes::momenta) {
      record_momenta();
    } else {
      record_velocities();  // for what is known of the record
      if (passes != Passes::velocities) out_.functions.clear();
    }
    if (passes == Passes::rates) record_rates();
    if (passes == Passes::solutions) record_solutions();
    return std::move(out_);
  }

 private:
  using Record = typename K::template Record<T>;
  using Body = PassBody<K, T, Link>;
  static constexpr std::size_t angles = K::angles.size(), record_size = sizeof(Record) / sizeof(T);

  void record_momenta() {
    pass("(22)-(26), (16): from the children", [&](const Body& b) {
      Inboard<T> a = children<Inboard<T>>();
      momentum_inboard(b, armature_.data(), mass_, gravity_, a);
      if (!root_) hand_on("t[", a, gravity_ ? 30 : 27);
    });
    pass("(17), (27), (21), (15), (20): from the parent", [&](const Body& b) {
      Outboard<T> a{};
      if (!root_) give("i[", &a.velocity.v.x, 6, 0);
      if (gravity_) give("i[", &a.gravity.x, 3, 6);
      momentum_outboard(b, mass_, a);
      if (!leaf_) hand_on("o[", a, gravity_ ? 9 : 6);
    });
  }
  void record_velocities() {
    pass("(17), (39): velocities and bias", [&](const Body& b) {
      Motion<T> a = parent();
      velocity_outboard(b, a);
      if (!leaf_) hand_on("o[", a, 6);
    });
    pass("(22)-(26), (16): from the children", [&](const Body& b) {
      Inboard<T> a = children<Inboard<T>>();
      force_inboard(b, armature_.data(), a);
      if (!root_) hand_on("t[", a, 27);
    });
    pass("(39), (27), (17): from the parent", [&](const Body& b) {
      Motion<T> a = accelerating_parent();
      acceleration_outboard(b, a);
      if (!leaf_) hand_on("o[", a, 6);
    });
  }
  void record_rates() {
    pass("(51), (39), (45): from the children", [&](const Body& b) {
      Force<T> W = children<Force<T>>();
      rate_inboard(b, W);
      if (!root_) hand_on("t[", W, 6);
    });
    pass("(47), (39): from the parent", [&](const Body& b) {
      Motion<T> a = accelerating_parent();
      rate_outboard(b, a);
      if (!leaf_) hand_on("o[", a, 6);
    });
  }
  void record_solutions() {
    pass("(51), (45): from the children", [&](const Body& b) {
      Force<T> W = children<Force<T>>();
      solution_inboard(b, W);
      if (!root_) hand_on("t[", W, 6);
    });
    pass("(47), (39): from the parent", [&](const Body& b) {
      Motion<T> a = parent();
      solution_outboard(b, a);
      if (!leaf_) hand_on("o[", a, 6);
    });
  }

  /// A pass with numbers of its own: it shares no operation with those before it. What it changes in the arrays it stores.
  template <class Text>
  void pass(const char* text, Text&& of_body) {
    out_.functions.emplace_back();
    out_.functions.back().comments.push_back({in_.size(), text});
    given_.clear();
    mass_ = in_.constant("mass");
    for (T& x : armature_) x = has_armature_ ? in_.constant("armature") : T(0);
    give("j.q[", q_.data(), NQ), give("j.c[", c_.data(), angles), give("j.s[", s_.data(), angles);
    give("u[", u_.data(), NV), give("qdot[", qdot_.data(), NQ), give("tau[", a_.data(), NV);
    give("p[", p_.data(), NV), give("pdot[", pdot_.data(), NV);
    give_all("m[", motion_), give_all("b[", bias_), give_all("x[", inboard_acceleration_), give_all("w[", reduced_bias_wrench_);
    give_all("l[", load_), give_all("r[", record_);
    T* const record = numbers_of(record_);
    for (std::size_t i = 0; i < record_size; ++i)
      if (known_[i] >= 0) record[i] = T::of_node(given_[given_.size() - record_size + i].node = known_[i]);
    const Body body{.link = link_,
                    .joint = {q_.data(), c_.data(), s_.data()},
                    .root = root_,
                    .alone = root_ && leaf_,
                    .record = record_,
                    .u = u_.data(),
                    .qdot = qdot_.data(),
                    .a = a_.data(),
                    .p = p_.data(),
                    .pdot = pdot_.data(),
                    .motion = &motion_,
                    .bias = &bias_,
                    .inboard_acceleration = &inboard_acceleration_,
                    .reduced_bias_wrench = &reduced_bias_wrench_,
                    .load = &load_};
    of_body(body);
    Function& f = out_.functions.back();
    for (const Given& one : given_)
      if (one.at->node() != one.node) f.stores.push_back({one.name, one.at->node()});
    f.end = in_.size();
    for (std::size_t i = 0; i < record_size; ++i)
      if (in_.expressions.nodes()[static_cast<std::size_t>(record[i].node())].operation == Operation::constant)
        known_[i] = record[i].node();
  }

  /// Memory that a pass reads and writes.
  struct Given {
    std::string name;
    T* at = nullptr;
    int node = 0;
  };
  static std::string place(const char* array, std::size_t i) { return array + std::to_string(i) + ']'; }
  void give(const char* array, T* to, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      to[i] = in_.number(place(array, i));
      given_.push_back({place(array, i), to + i, to[i].node()});
    }
  }
  template <class V>
  static T* numbers_of(V& all) {
    static_assert(sizeof(V) % sizeof(T) == 0 && std::is_trivially_copyable_v<V>);
    return reinterpret_cast<T*>(&all);
  }
  template <class V>
  void give_all(const char* array, V& all) {
    give(array, numbers_of(all), sizeof all / sizeof(T));
  }
  /// Numbers that another body hands on.
  void give(const char* array, T* to, std::size_t n, std::size_t first) {
    for (std::size_t i = 0; i < n; ++i) to[i] = in_.number(place(array, first + i));
  }
  template <class V>
  V children() {
    V all{};
    if (!leaf_) give("s[", numbers_of(all), sizeof all / sizeof(T), 0);
    return all;
  }
  Motion<T> parent() {
    Motion<T> a{};
    if (!root_) give("i[", numbers_of(a), 6, 0);
    return a;
  }
  /// The ground accelerates against gravity, and does not turn.
  Motion<T> accelerating_parent() {
    Motion<T> a{};
    give("i[", numbers_of(a), root_ ? 3 : 6, 0);
    return a;
  }
  template <class V>
  void hand_on(const char* array, V& all, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) out_.functions.back().last.push_back({place(array, i), numbers_of(all)[i].node()});
  }

  bool leaf_, root_, gravity_, has_armature_;
  Recorder& in_;
  Link link_;
  T mass_;
  std::array<T, NQ> q_, qdot_;
  std::array<T, angles> c_, s_;
  std::array<T, NV> u_, a_, p_, pdot_, armature_;
  Record record_;
  BodySweep<T> motion_;
  BodyBias<T> bias_;
  Motion<T> inboard_acceleration_;
  Force<T> reduced_bias_wrench_, load_;
  std::vector<Given> given_;
  std::array<int, record_size> known_ = [] {
    std::array<int, record_size> none;
    none.fill(-1);
    return none;
  }();
  Derived out_{};
};

}  // namespace momentree::derive
