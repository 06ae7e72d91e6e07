#include <momentree/joint/motion.hpp>

#include <cmath>
#include <numbers>

#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sine_cosine.hpp>

namespace momentree {

namespace {

// The kernels use axes C of their own. Calls act(kernels, C, a link without placement, the joint's state).
template <class Act>
decltype(auto) with_kernels(const JointSpec& joint, const double* q, Act act) {
  return dispatch(joint.kind, [&](auto tag) {
    using K = typename decltype(tag)::type::Kernels;
    LinkConstants link;
    const Mat3 C = K::frame(joint, link.geometry);
    double c[2] = {}, s[2] = {};
    for (std::size_t i = 0; i < K::angles.size(); ++i) {
      const SineCosine angle = sine_cosine(q[K::angles[i]]);
      c[i] = angle.c, s[i] = angle.s;
    }
    return act(std::type_identity<K>{}, C, link, JointState<double>{q, c, s});
  });
}

}  // namespace

Pose joint_motion(const JointSpec& joint, const double* q) {
  return with_kernels(joint, q, [](auto tag, const Mat3& C, const LinkConstants& link, const JointState<double>& state) -> Pose {
    Mat3 R;
    Vec3 r;
    decltype(tag)::type::template pose<double>(link, state, R, r);
    return {C * r, quaternion_of(C * (R * transpose(C)))};
  });
}

std::vector<Motion<double>> joint_dofs(const JointSpec& joint, const double* q) {
  return with_kernels(joint, q, [](auto tag, const Mat3& C, const LinkConstants& link, const JointState<double>& state) {
    std::vector<Motion<double>> all;
    for (const Motion<double>& e : decltype(tag)::type::template columns<double>(link, state)) all.push_back({C * e.v, C * e.w});
    return all;
  });
}

std::optional<Values> joint_coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint) {
  return dispatch(joint.kind, [&](auto tag) -> std::optional<Values> {
    using K = typename decltype(tag)::type;
    double q[Values::capacity] = {};
    if (!K::Kernels::coordinates(joint, motion, hint, q)) return std::nullopt;
    Values values;
    for (int i = 0; i < K::info.nq; ++i) values.push_back(q[i]);
    return values;
  });
}

void nearest_coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) noexcept {
  dispatch(joint.kind, [&](auto tag) { decltype(tag)::type::Kernels::coordinates(joint, motion, hint, q); });
}

Turns turns_of(Kind kind, const double* q) noexcept {
  double angles[2] = {};
  int count = 0;
  for (int i = 0; i < info(kind).nq && count < 2; ++i)
    if (info(kind).q_units[i] == 'r') angles[count++] = q[i];
  return {angles[0], angles[1]};
}

Closure closure_of(const JointSpec& joint) noexcept {
  Closure rows;
  dispatch(joint.kind, [&](auto tag) { decltype(tag)::type::Kernels::closure(joint, rows); });
  return rows;
}

std::optional<LockedForm> locked_form(const JointSpec& joint, unsigned locked, const Values& held) noexcept {
  LockedForm form;
  const auto all = (1u << info(joint.kind).nv) - 1;
  if (locked == 0) {
    form.rows = closure_of(joint);
  } else if (locked == all) {
    form.parent = joint_motion(joint, held.begin());
    form.rows.add_point(), form.rows.add_rotation();
  } else {
    const bool has = dispatch(joint.kind, [&](auto tag) {
      using K = typename decltype(tag)::type::Kernels;
      if constexpr (requires { K::lock_part(joint, locked, held.begin(), form); }) {
        K::lock_part(joint, locked, held.begin(), form);
        return true;
      }
      return false;
    });
    if (!has) return std::nullopt;
  }
  return form;
}

int joint_columns(const JointSpec& joint, const double* q, Motion<double>* columns) noexcept {
  return with_kernels(joint, q, [columns](auto tag, const Mat3& C, const LinkConstants& link, const JointState<double>& state) {
    int count = 0;
    for (const Motion<double>& e : decltype(tag)::type::template columns<double>(link, state))
      columns[count++] = {C * e.v, C * e.w};
    return count;
  });
}

void joint_columns_rate(const JointSpec& joint, const double* q, const double* u, Motion<double>* rates) noexcept {
  std::fill_n(rates, info(joint.kind).nv, Motion<double>{});
  with_kernels(joint, q, [&](auto tag, const Mat3& C, const LinkConstants& link, const JointState<double>& state) {
    using K = typename decltype(tag)::type;
    if constexpr (requires { K::template columns_rate<double>(link, state, u); }) {
      const auto own = K::template columns_rate<double>(link, state, u);
      for (std::size_t i = 0; i < own.size(); ++i) rates[i] = {C * own[i].v, C * own[i].w};
    }
  });
}

Motion<double> joint_columns_drift(const JointSpec& joint, const double* q, const double* u) noexcept {
  Motion<double> rates[6], sum{};
  joint_columns_rate(joint, q, u, rates);
  for (int i = 0; i < info(joint.kind).nv; ++i) sum = sum + Motion<double>{u[i] * rates[i].v, u[i] * rates[i].w};
  return sum;
}

Force<double> joint_wrench(const JointSpec& joint, const double* q, unsigned locked, const double* force) noexcept {
  return with_kernels(joint, q, [&](auto tag, const Mat3& C, LinkConstants& link, const JointState<double>& state) {
    using K = typename decltype(tag)::type;
    if constexpr (requires { K::drive_wrench(link, state, force); }) {
      link.locked = static_cast<unsigned char>(locked);
      const Force<double> W = K::drive_wrench(link, state, force);
      return Force<double>{C * W.l, C * W.h};
    }
    return Force<double>{};
  });
}

Values joint_zero(Kind kind) {
  return dispatch(kind, [](auto tag) {
    using K = typename decltype(tag)::type;
    double q[Values::capacity] = {};
    K::Kernels::zero(q);
    Values values;
    for (int i = 0; i < K::info.nq; ++i) values.push_back(q[i]);
    return values;
  });
}

namespace coordinates {

bool negligible(const Vec3& displacement) { return norm(displacement) <= tolerance; }
bool negligible(const Quat& rotation) { return norm(log_rotation(rotation)) <= tolerance; }

double unwrapped(double angle, double hint) {
  constexpr double turn = 2 * std::numbers::pi;
  const double near = angle + turn * std::round((hint - angle) / turn);
  return std::fabs(near - hint) <= tolerance * (1 + std::fabs(hint)) ? hint : near;
}

bool about_axis(const Vec3& axis, const Quat& rotation, double hint, double& angle) {
  const Vec3 v{rotation.x, rotation.y, rotation.z};
  const double along = dot(axis, v);
  angle = unwrapped(2 * std::atan2(along, rotation.w), hint);
  return norm(v - along * axis) <= tolerance;
}

bool along_axis(const Vec3& axis, const Vec3& displacement, double& length) {
  length = dot(axis, displacement);
  return norm(displacement - length * axis) <= tolerance * (1 + std::fabs(length));
}

}  // namespace coordinates
}  // namespace momentree
