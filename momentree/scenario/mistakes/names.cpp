// Names of kinds and methods in other engines and formats.
#include <momentree/base/edit_distance.hpp>
#include <momentree/scenario/mistakes/mistakes.hpp>

namespace momentree::io {

namespace {

struct Name {
  const char *words, *meant, *why;
};

constexpr Name kinds[] = {
    {"hinge rotary rotational rotation rot pin continuous pivot turn axle", "revolute", ""},
    {"slide slider slides sliding prism translational translation linear piston rail", "prismatic", ""},
    {"fixed fix rigid static welded glued bolted clamped", "weld", ""},
    {"floating float freeflyer freeflying free6 6dof sixdof", "free", ""},
    {"spherical sphere ballandsocket socket ballsocket point2point pointtopoint gimbal rotation3d", "ball", ""},
    {"screw thread", "helical", " with pitch = \"5 mm\", the displacement per turn"},
    {"cardan hooke hookes ujoint revolute2 hinge2", "universal", " with axis and axis2"},
    {"cylinder cyl slidinghinge", "cylindrical", ""},
    {"plane planar2d", "planar", ""},
};

constexpr Name methods[] = {
    {"rk45 ode45 dp5 dp45 dormandprince dormandprince5 dopri dopri45 rkf45 fehlberg cashkarp adaptive variable variablestep "
     "automatic auto rk5 tsit5 ode23 rk23 bogackishampine rungekutta45 rungekutta3 rkdp",
     "dopri5", ", the Runge-Kutta method of Dormand and Prince that chooses its steps"},
    {"ode113 dopri8 dopri853 dop8 rk8 rk78 ode78 ode89 vern7 vern9", "dop853", ", of order 8, which chooses its steps"},
    {"rk rungekutta rungekutta4 classic rk2 rk3 heun euler expliciteuler forwardeuler rk1 ab2 adamsbashforth ode4 fixed", "rk4",
     ", the classic Runge-Kutta method of order 4"},
    {"semiimplicit semiimpliciteuler symplectic symplecticeuler verlet velocityverlet leapfrog stormerverlet implicitmidpoint "
     "variational gauss",
     "midpoint", ", which is symplectic"},
    {"implicit implicitfast impliciteuler backwardeuler bdf cvode lsoda ida radau radau5 ode15s ode23s ode23t ode23tb rosenbrock "
     "trapezoidal trapezoid trbdf2 stiff exponential",
     "damped", ", which takes dampers and servos implicitly, or \"dopri5\""},
};

// The result of plain_word() without the word "joint", which URDF tools and Drake add to the names of kinds.
std::string bare(std::string_view word) {
  std::string plain = plain_word(word.substr(0, 40));
  constexpr std::string_view joint = "joint";
  if (plain.size() > joint.size() && plain.ends_with(joint)) plain.resize(plain.size() - joint.size());
  return plain;
}

bool among(std::string_view word, std::string_view words) {
  const std::string padded = " " + std::string(words) + " ";
  return word.find(' ') == std::string_view::npos && padded.find(" " + std::string(word) + " ") != std::string::npos;
}

template <std::size_t n>
const Name* find(const Name (&names)[n], std::string_view word) {
  for (const Name& each : names)
    if (among(word, each.words) || word == each.meant) return &each;
  return nullptr;
}

std::string written(const char* key, const Name& name) {
  return "write " + std::string(key) + " = \"" + name.meant + "\"" + name.why;
}

}  // namespace

std::string cure_of_kind(std::string_view word) {
  const Name* name = find(kinds, bare(word));
  return name ? written("kind", *name) : "";
}

std::string cure_of_method(std::string_view word) {
  const Name* name = find(methods, plain_word(word.substr(0, 40)));
  return name ? written("method", *name) : "";
}

std::string cure_of_root(std::string_view word) {
  const std::string plain = bare(word);
  if (among(plain, "floating float freeflyer 6dof unfixed loose")) return "write root = \"free\"";
  if (among(plain, "world ground weld welded static anchored rigid fix fixedbase pinned")) return "write root = \"fixed\"";
  return "";
}

bool means_ground(std::string_view word) { return among(plain_word(word.substr(0, 40)), "world earth inertial universe floor"); }

}  // namespace momentree::io
