#pragma once
// Closed contacts: their rows, and the forces with which the accelerations obey them.
//
// A contact has a row n along its normal and two tangential ones. While it sticks, all three relative accelerations are zero;
// while it slips in the direction s, the normal one is zero and the force on body a is N (n − μ s). With J the rows, Y = M⁻¹ Jᵀ
// (loops included) and w the relative accelerations without contacts, the forces r follow from J Y B r = −w, where B r are the
// forces along the rows. Redundant contacts are the rule, such as four corners of a box: of all forces with the same effect the
// least ones are taken that press and are within their cones of friction (contact/shared_forces.hpp).
#include <algorithm>
#include <span>
#include <vector>

#include <momentree/contact/shared_forces.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/springs.hpp>

namespace momentree {

/// Slower slip has no direction of its own (m/s).
inline constexpr double slowest_slip = 1e-9;

/// The velocity of the surface of a, less that of b, relative to their bodies (m/s, world axes): it is along the surfaces.
Vec3 belt_velocity(const Contact& contact, const contact::Touch& touch, const contact::Place& a, const contact::Place& b);

/// The direction of row k of a contact: its normal, or one of its tangents.
inline const Vec3& along(const contact::Touch& touch, std::size_t k) { return k == 0 ? touch.normal : touch.tangent[k - 1]; }

/// Three rows of each contact: along the normal and the tangents of contact::Touch.
struct ContactRows {
  /// Contacts of one island, whose impulses act on the degrees of freedom of the island alone: A is zero between groups.
  struct Group {
    std::size_t first = 0, count = 0;     ///< its contacts, in `members`
    std::size_t first_dof = 0, dofs = 0;  ///< the degrees of freedom of its mechanisms, in `dof`
    std::size_t at = 0;                   ///< where its rows begin in J and Y, each with `dofs` numbers
    std::size_t at_A = 0;                 ///< where its matrix begins in A: 3 count rows and columns
    bool redundant = false;               ///< several forces have the same effect
    bool shared = false;                  ///< the least of them are not possible, and others were chosen
    double margin = 0;                    ///< of these, see SharedForces; of states, not of stages
  };
  std::vector<contact::Touch> touches;
  std::vector<Group> groups;                 ///< in the order of their first contacts
  std::vector<std::size_t> members;          ///< numbers of contacts, group by group, in ascending order
  std::vector<std::size_t> group_of, place;  ///< by contact: its group, and its place among the members of that
  std::vector<int> dof;                      ///< places in arrays packed as p, group by group, in ascending order
  std::vector<double> J, Y, A;               ///< A = J Y, by group
  std::vector<double> velocity;              ///< J u, and that of belts
  std::vector<double> belts;                 ///< the part of it that is that of belts
  std::vector<double> acceleration;          ///< its time derivative without forces of contacts
  std::vector<double> forces;                ///< along the rows, on body a
  std::vector<double> open;                  ///< forces that move nothing, which others have in common; of states, not of stages
  std::vector<Vec3> slip;                    ///< by contact: direction of slip
  std::size_t contacts() const { return touches.size(); }
  bool has_belts() const {
    return std::ranges::any_of(belts, [](double v) { return v != 0; });
  }
  /// No other force of this contact has the same effect, whatever the others exert.
  bool determined(std::size_t contact) const {
    return open[3 * contact] == 0 && open[3 * contact + 1] == 0 && open[3 * contact + 2] == 0;
  }
  std::span<const std::size_t> of_group(const Group& group) const { return {members.data() + group.first, group.count}; }
  /// The element of A for two rows.
  double mobility(std::size_t row, std::size_t column) const;
  /// A of all rows, with zeros between groups.
  std::vector<double> matrix() const;
  /// Adds a row of J or Y, times a factor, to an array packed as p.
  void add_row(const std::vector<double>& of, std::size_t row, double factor, double* packed) const;
  /// The rows of some contacts, by their numbers, as one group without J and Y.
  ContactRows some(const std::vector<std::size_t>& numbers) const;
  /// Numbers of contacts that move each other, according to A: the islands.
  std::vector<std::vector<std::size_t>> islands() const;
};

/// A force at a point, world axes, on body a and its opposite on body b; −1: the ground.
struct HeldForce {
  int a = -1, b = -1;
  Vec3 point{}, force{};  ///< m, N
  Vec3 normal{}, slip{};  ///< of the contact that exerts it: unit vector from b to a, and velocity of a along b (m/s)
  int cable = -1;         ///< the spring of the model that exerts it; −1: bodies touch
  Vec3 moment{};          ///< on a, of torsional and rolling friction (N m)
};

/// What a stop of a joint of the tree does that is stepped through.
struct HeldStop {
  int joint, dof;
  double force;  ///< along the degree of freedom (N or N m)
  bool rests;    ///< the joint rests on it
};

/// Memory of contacts, part of a Workspace.
struct ContactWorkspace {
  ContactRows rows;
  std::vector<HeldForce> held;  ///< in evaluations of states, but not in stages: the forces of contacts that are stepped through
  std::vector<HeldStop> stops;  ///< the same of stops
  bool solved = true;           ///< the forces are finite
  std::vector<double> matrix, right, change, move, missing;  ///< scratch
  std::vector<double> row, row_size, unit_row;               ///< scratch
  std::vector<double> packed;                                ///< scratch, packed as p; zero between calls
  std::vector<std::size_t> columns, unknowns;
  contact::SharedForces shared;
  std::vector<contact::ForceCone> cones;
  std::vector<double> independent;     ///< equations of the forces, orthonormal; empty if these are unique; scratch
  std::uint64_t mechanisms_of = 0;     ///< Tree::revision() for which the following were found
  std::vector<int> root_of;            ///< by body: the root of its mechanism
  std::vector<int> begin_of, end_of;   ///< by root: its bodies in the tree's order
  std::vector<int> first_of, last_of;  ///< by root: between which numbers of p those of its joints are
  std::vector<int> island_of;          ///< by body: the number of its island without contacts
  std::vector<std::size_t> dofs_of;    ///< by that number: where its degrees of freedom begin in `dof`
  std::vector<int> dof;                ///< places in arrays packed as p, island by island
  std::vector<int> joined, touched;    ///< islands that contacts join; scratch of find_contact_mobility
  std::vector<std::size_t> group_of;   ///< by number of an island: its group; scratch
  std::vector<Vec3> chosen_slip;       ///< by contact: direction of slip at the last state
  std::uint64_t topology = 0;          ///< Tree::revision() for which it was chosen
};

/// Geometry and velocities of contacts at q. Requires workspace.bodies of this configuration: locate_stage.
void place_contacts(const Tree& tree, const Workspace<double>& workspace, std::span<const Contact> contacts, ContactRows& rows);

/// A row along which no impulse changes the relative velocity of two bodies, as of bodies that are locked together or welded
/// into a loop, or that both follow prescribed motions: its mobility is zero, apart from rounding.
struct RowOfRigid {
  bool rigid = false;
  bool rests = false;  ///< its velocity is zero, too, apart from rounding: no prescribed motion moves them
};
/// `k`: 0 is the normal, 1 and 2 are the tangents. Its velocity is compared with those of the bodies. Requires the factors of an
/// evaluation at q.
RowOfRigid rigid_row(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                     const contact::Touch& touch, std::size_t k, double mobility, double velocity);

/// J, Y and A of contacts that are placed. Requires the factors of an evaluation at q. With loops the workspace then holds no
/// evaluation. Rows of rigid pairs become zero; of those at rest, their velocities and accelerations, too.
void find_contact_mobility(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                           ContactRows& rows);

/// Accelerations along the rows of contacts that are placed. Requires accelerations in the workspace: as after `accelerate`.
void find_contact_accelerations(const Tree& tree, const double* q, const Workspace<double>& workspace,
                                std::span<const Contact> contacts, ContactRows& rows);

/// The angular acceleration of a, less that of b (rad/s², world axes). Requires accelerations in the workspace.
Vec3 spin_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, const Contact& contact);

/// Adds to `row`, packed as p, the joint forces of a unit force along a direction at a point (world axes), times `sign`.
void add_contact_row(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Vec3& along,
                     const Vec3& point, double sign, double* row);

/// Adds to `row`, packed as p, the joint forces of a wrench on a body, in its kernel frame.
void add_wrench_row(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Force<double>& wrench,
                    double* row);

/// The workspace's memory of contacts, which it then has.
ContactWorkspace& contact_memory(Workspace<double>& workspace);
/// The workspace's held forces, which it then has memory for.
std::vector<HeldForce>& held_forces(Workspace<double>& workspace);
/// Adds the forces of held stops to joint forces, packed as p.
void add_held_stops(const Tree& tree, const Workspace<double>& workspace, double* tau) noexcept;
/// Calls add(body, wrench in its kernel frame) for each held force. Requires workspace.bodies of this configuration.
template <class Add>
void for_held_forces(const Tree& tree, const Workspace<double>& workspace, Add add);

/// Finds the forces of the tree's contacts, from an evaluation without them, in workspace.contacts. `at_state`: the directions of
/// slip are chosen; stages keep to their half-plane.
void find_contact_forces(const Tree& tree, const double* q, Workspace<double>& workspace, bool at_state);

/// Adds these forces to workspace.loads, and what friction dissipates and belts do to workspace.power.
void add_contact_loads(const Tree& tree, Workspace<double>& workspace) noexcept;

/// Closes the contacts after a step: sets gaps to zero and removes the velocities that contacts do not allow, in place, by the
/// least change in the metric of the mass matrix. The workspace then belongs to no state. `energy`: what this added (J).
[[nodiscard]] bool close_contacts(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace, double& energy);

/// The impulses that remove the velocities that these contacts do not allow, in workspace.contacts->change, along the rows in
/// workspace.contacts->rows. The workspace then belongs to no state.
[[nodiscard]] bool find_stopping_impulses(const Tree& tree, double t, const double* q, const double* u,
                                          Workspace<double>& workspace, std::span<const Contact> contacts);

/// A force at a point of the world as a wrench on a body, in its kernel frame.
Force<double> contact_wrench(const Workspace<double>& workspace, int body, const Vec3& force, const Vec3& point);

template <class Add>
void for_held_forces(const Tree& tree, const Workspace<double>& workspace, Add add) {
  if (workspace.contacts == nullptr) return;
  const auto pull = [&](int body, const Vec3& force, const Vec3& point, const Vec3& moment = {}) {
    if (body < 0 || !tree.alive(body)) return;
    Force<double> wrench = contact_wrench(workspace, body, force, point);
    wrench.h += transpose_times(workspace.bodies[static_cast<std::size_t>(body)].R, moment);
    add(body, wrench);
  };
  for (const HeldForce& held : workspace.contacts->held) {
    if (held.cable >= 0) {  // it has moved since: it pulls along itself
      const SpringMotion motion = spring_motion(tree, workspace, held.cable);
      const Spring& cable = tree.springs()[static_cast<std::size_t>(held.cable)];
      const Vec3 force = dot(held.force, held.normal) * motion.direction;
      pull(cable.from.body.index, force, motion.from);
      pull(cable.to.body.index, -force, motion.to);
      continue;
    }
    pull(held.a, held.force, held.point, held.moment);
    pull(held.b, -held.force, held.point, -held.moment);
  }
}

}  // namespace momentree
