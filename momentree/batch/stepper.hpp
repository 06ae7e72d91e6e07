#pragma once
// Steps of a block of worlds, one per lane, of one topology. The same text is compiled for each instruction set.
#include <memory>
#include <vector>

#include <momentree/math/pack.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// What worlds in lanes compute in. Their states are kept as doubles either way.
enum class Precision : unsigned char { float64, float32 };

namespace batch {

/// How the forces in the joints of one topology are found.
struct ForcePlan {
  struct Spring {
    int q, p;                ///< packed
    double stiffness, rest;  ///< N m/rad, rad; N/m, m
  };
  std::vector<Spring> springs;  ///< freedoms that have one, are not locked, and are rates of coordinates
  std::vector<int> elements;    ///< bodies whose joint has other forces: those are found lane by lane
  ForcePlan() = default;
  explicit ForcePlan(const Tree& tree);
};

/// Worlds in lanes; number i of lane l stands at [i·lanes + l].
struct Block {
  double *q, *p;              ///< packed, nq and nv numbers per lane
  const double* effort;       ///< more efforts, packed as p; null: none
  double* time;               ///< s, by lane
  const double* h;            ///< s, by lane: the step of each world; 0: it stays as it is, to the last bit
  unsigned char* ran_away{};  ///< by lane: set where a step diverged; that world is left as it was before
};

class Stepper {
 public:
  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;
  virtual ~Stepper();
  virtual int lanes() const = 0;
  /// A step of the classical Runge–Kutta method in every lane. The tree has no more bodies than that of the constructor. Neither
  /// allocates nor throws.
  virtual void step(const Tree& tree, const ForcePlan& plan, const Block& block) noexcept = 0;
  /// One evaluate_rates: q̇, ṗ (without joint forces) and v of the lanes.
  virtual void rates(const Tree& tree, const double* q, const double* p, double* qdot, double* pdot, double* v) noexcept = 0;
};

/// True where this library has kernels for the instruction set and this CPU can run them.
bool available(Isa isa) noexcept;
/// The widest of those up to `widest`; a build without any of these gives the narrowest that it has.
Isa best_isa(Isa widest = Isa::avx512) noexcept;
/// Null where it is not available.
std::unique_ptr<Stepper> make_stepper(Isa isa, Precision precision, const Tree& tree);

// One source file each.
Stepper* make_baseline_double(const Tree& tree);
Stepper* make_baseline_float(const Tree& tree);
Stepper* make_avx2_double(const Tree& tree);
Stepper* make_avx2_float(const Tree& tree);
Stepper* make_avx512_double(const Tree& tree);
Stepper* make_avx512_float(const Tree& tree);

// What is done lane by lane, in double, for all instruction sets alike. q, u, force: those of b's joint alone.

/// Adds the forces of the plan's elements in b's joint at time t.
void add_element_forces(const Tree& tree, int b, double t, const double* q, const double* u, double* force) noexcept;
/// Position, rate and acceleration of b's prescribed motion at time t.
void motion_at(const Tree& tree, int b, double t, double* point) noexcept;
/// Quaternions of b's joint to length one.
void normalise_joint(const Tree& tree, int b, double* q) noexcept;
/// Coordinates and freedoms of b's joint.
int coordinates_of(const Tree& tree, int b) noexcept;
int dofs_of(const Tree& tree, int b) noexcept;

}  // namespace batch
}  // namespace momentree
