#include <momentree/integrate/stiffness.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/integrate/method_list.hpp>
#include <momentree/integrate/methods.hpp>

namespace momentree {

namespace {

struct Limits {
  double damper, spring;
  double explicit_damper;  // of dampers that the method never treats implicitly
};

template <class Method>
constexpr double explicit_damper_limit() {
  if constexpr (requires { Method::explicit_damper_limit; })
    return Method::explicit_damper_limit;
  else
    return Method::damper_limit;
}

// Stability limits of a method: the product of a rate (1/s) and the step.
Limits limits_of(std::string_view method) {
#define MOMENTREE_METHOD(name, Type) \
  if (method == #name) return {Type::damper_limit, Type::spring_limit, explicit_damper_limit<Type>()};
  MOMENTREE_METHODS(MOMENTREE_METHOD)
#undef MOMENTREE_METHOD
  return {HUGE_VAL, HUGE_VAL, HUGE_VAL};
}

// Dampers and springs of a DoF.
struct Dof {
  int joint;
  int loop;   // place in tree.loops(); −1: a joint of the tree
  int place;  // of the joint's DoFs, in a loop; otherwise of p
  double damping, kd, stiffness, kp;
  bool turns;
};

// `free`: the joint's DoFs that are neither locked nor driven. `first`: the place of its first one.
void add_dofs(Kind of, const JointParameters& p, unsigned free, int joint, int loop, int first, std::vector<Dof>& all) {
  const KindInfo& kind = info(of);
  const JointDrive::Pd* pd = p.drive != nullptr && p.drive->pd.any() ? &p.drive->pd : nullptr;
  for (int i = 0; i < kind.nv; ++i) {
    if ((free >> i & 1u) == 0) continue;
    const Dof dof{joint,
                  loop,
                  first + i,
                  p.damping.of(i),
                  pd != nullptr ? pd->kd.of(i) : 0,
                  p.stiffness.of(i),
                  pd != nullptr ? pd->kp.of(i) : 0,
                  kind.v_units[i] == 'r'};
    if (dof.damping + dof.kd > 0 || dof.stiffness + dof.kp > 0) all.push_back(dof);
  }
}

std::vector<Dof> stiff_dofs(const Tree& tree) {
  std::vector<Dof> all;
  for (const int b : tree.order()) {
    const JointParameters* p = tree.parameters(b);
    if (p != nullptr && tree.link(b).driven == 0)
      add_dofs(tree.kind(b), *p, ~tree.link(b).locked, tree.joint_of(b), -1, tree.first_p(b), all);
  }
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const bool moves = loop.parameters.drive != nullptr && loop.parameters.drive->moves();
    if (!moves) add_dofs(loop.joint.kind, loop.parameters, ~loop.joint.locked, loop.id().index, static_cast<int>(i), 0, all);
  }
  return all;
}

// Velocities that unit efforts and impulses cause at coordinates q, with all loops closed.
class Mobility {
 public:
  Mobility(const Tree& tree, std::span<const double> q)
      : tree_(tree),
        state_(tree, tree.has_loops() ? Variables::velocities : Variables::momenta),
        workspace_(tree),
        u_(static_cast<std::size_t>(tree.nv())) {
    state_.assign(0, q, u_, tree);
    if (tree.has_loops()) forward_dynamics(tree, state_, workspace_);
  }
  const State& state() const { return state_; }
  Workspace<double>& workspace() { return workspace_; }

  /// Of a DoF: the diagonal entry of H⁻¹, which is at most the fastest rate caused by a unit of damping there.
  double of(const Dof& dof) {
    const double* const q = state_.q().data();
    if (dof.loop >= 0) return strike_loop(tree_, q, workspace_, dof.loop, dof.place, u_.data());
    const auto place = static_cast<std::size_t>(dof.place);
    std::fill(u_.begin(), u_.end(), 0.0);
    u_[place] = 1;
    if (tree_.has_loops()) return solve_with_loops(tree_, q, workspace_, u_.data()), u_[place];
    evaluate_rates<double>(tree_, q, u_.data(), workspace_);
    return workspace_.v[place];
  }
  /// Of generalised impulses p along themselves.
  double of(const std::vector<double>& p) {
    u_ = p;
    if (tree_.has_loops())
      solve_with_loops(tree_, state_.q().data(), workspace_, u_.data());
    else
      solve_mass(tree_, state_, workspace_, p.data(), u_.data());
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p[i] * u_[i];
    return sum;
  }

 private:
  const Tree& tree_;
  State state_;
  Workspace<double> workspace_;
  std::vector<double> u_;
};

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", x);
  return buffer;
}

}  // namespace

std::string StiffJoint::what(std::string_view joint_name, double step) const {
  const std::string name = "joint '" + std::string(joint_name) + "'";
  const char* const unit = damper ? (turns ? " N m s/rad" : " N s/m") : (turns ? " N m/rad" : " N/m");
  return std::string(servo    ? "the servo of "
                     : damper ? "the damper of "
                              : "the spring of ") +
         name + " (" +
         (servo    ? (damper ? "kd = " : "kp = ")
          : damper ? "damping = "
                   : "stiffness = ") +
         text(coefficient) + unit + " on " + text(inertia) + (turns ? " kg m^2" : " kg") + ") is too stiff for steps of " +
         text(step) + " s";
}

std::string StiffJoint::cure() const {
  const std::string steps = "a step below " + text(longest_step) + " s";
  return damped_helps ? "use method = \"damped\", or " + steps : "use " + steps;
}

std::optional<StiffJoint> too_stiff(const Tree& tree, std::span<const double> q, std::string_view method, double step) {
  const Limits limits = limits_of(method);
  std::vector<Dof> dofs = stiff_dofs(tree);
  if (dofs.empty() || !std::isfinite(limits.spring)) return {};
  constexpr std::size_t most_bodies_solved = 4'000'000;
  const std::size_t most = std::max<std::size_t>(1, most_bodies_solved / static_cast<std::size_t>(tree.bodies()));
  if (dofs.size() > most) {
    const auto size = [](const Dof& f) { return std::max(f.damping + f.kd, f.stiffness + f.kp); };
    std::nth_element(dofs.begin(), dofs.begin() + static_cast<std::ptrdiff_t>(most), dofs.end(),
                     [&](const Dof& a, const Dof& b) { return size(a) > size(b); });
    dofs.resize(most);
  }
  Mobility mobilities(tree, q);
  std::optional<StiffJoint> worst;
  double worst_excess = 1;
  for (const Dof& f : dofs) {
    const double mobility = mobilities.of(f);
    if (!(mobility > 0) || !std::isfinite(mobility)) continue;
    const double damping = f.damping + f.kd, stiffness = f.stiffness + f.kp;
    // "damped" adds γ h c to the inertia in this DoF.
    const auto swing = [&](bool damped) {
      const bool implicit = damped && f.loop < 0;
      return std::sqrt(stiffness / (1 / mobility + (implicit ? Damped::implicit_share * step * damping : 0)));
    };
    const Limits damped = limits_of("damped");
    const bool helps = f.loop < 0 && swing(true) * step <= damped.spring;
    const auto consider = [&](bool damper, double rate, double limit) {
      const double excess = rate * step / limit;
      if (!(excess > worst_excess)) return;
      worst_excess = excess;
      worst = StiffJoint{
          f.joint,      damper,       damper ? f.kd > f.damping : f.kp > f.stiffness, f.turns, damper ? damping : stiffness,
          1 / mobility, limit / rate, method != "damped" && helps && damping > 0};
    };
    consider(true, damping * mobility, f.loop < 0 ? limits.damper : limits.explicit_damper);
    consider(false, swing(method == "damped"), limits.spring);
  }
  return worst;
}

std::string StiffSpring::what(std::string_view name, double step) const {
  return std::string(damper ? "the damper of spring '" : "spring '") + std::string(name) + "' (" +
         (damper ? "damping = " : "stiffness = ") + text(coefficient) + (damper ? " N s/m" : " N/m") + " on " + text(mass) +
         " kg) is too stiff for steps of " + text(step) + " s";
}

std::string StiffSpring::cure() const { return "use a step below " + text(longest_step) + " s, or an adaptive method: dopri5"; }

std::optional<StiffSpring> too_stiff_spring(const Tree& tree, std::span<const double> q, std::string_view method, double step) {
  const Limits limits = limits_of(method);
  if (tree.springs().count() == 0 || tree.nv() == 0 || !std::isfinite(limits.spring)) return {};
  const auto n = static_cast<std::size_t>(tree.nv());
  Mobility mobilities(tree, q);
  const State& state = mobilities.state();
  Workspace<double>& workspace = mobilities.workspace();
  std::vector<double> J(6 * n), p(n);
  constexpr std::size_t most_numbers = 20'000'000;
  int left = static_cast<int>(std::min<std::size_t>(1 + most_numbers / (6 * n), 100'000));
  std::optional<StiffSpring> worst;
  double worst_excess = 1;
  for (int s = 0; s < tree.springs().count() && left > 0; ++s) {
    if (!spring_acts(tree, s)) continue;
    locate_bodies(tree, state, workspace);
    const SpringMotion motion = spring_motion(tree, workspace, s);
    const SpringLaw& law = tree.springs().law(s);
    if (!(motion.length > 0) || law.slack(motion.length)) continue;
    --left;
    std::fill(p.begin(), p.end(), 0.0);  // momenta of unit impulses at both ends
    const Spring& spring = tree.springs()[static_cast<std::size_t>(s)];
    for (const auto& [end, sign] : {std::pair{spring.from, -1.0}, {spring.to, 1.0}}) {
      if (end.body == ground) continue;
      point_jacobian(tree, state, workspace, end.body, end.point, J.data());
      const Vec3 along = sign * motion.direction;
      for (std::size_t i = 0; i < n; ++i) p[i] += along.x * J[i] + along.y * J[n + i] + along.z * J[2 * n + i];
    }
    const double mobility = mobilities.of(p);
    if (!(mobility > 0) || !std::isfinite(mobility)) continue;
    const auto consider = [&](bool damper, double rate, double limit) {
      const double excess = rate * step / limit;
      if (!(excess > worst_excess)) return;
      worst_excess = excess;
      worst = StiffSpring{s, damper, damper ? law.damping : law.stiffness, 1 / mobility, limit / rate};
    };
    consider(true, law.damping * mobility, limits.explicit_damper);
    consider(false, std::sqrt(law.stiffness * mobility), limits.spring);
  }
  return worst;
}

}  // namespace momentree
