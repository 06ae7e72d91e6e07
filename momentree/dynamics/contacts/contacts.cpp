#include <momentree/dynamics/contacts/contacts.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/contact/linear.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sine_cosine.hpp>

namespace momentree {

namespace {

constexpr double redundant = 1e-9;  // pivots of rows that depend on others, relative to the elements of A

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Of a body's user frame.
contact::Place place_of(const Tree& tree, const Workspace<double>& workspace, int body) {
  if (body < 0) return {};
  const Kinematics<double>& k = workspace.bodies[at(body)];
  const KernelFrame& frame = tree.frame(body);
  contact::Place place;
  place.R = k.R * transpose(frame.R);
  const Vec3 to = -(place.R * frame.r);
  place.r = k.r + to;
  place.w = k.R * k.velocity.w;
  place.v = k.R * k.velocity.v + cross(place.w, to);
  return place;
}

// Direction of row i of a touch: the normal and the tangents.
const Vec3& direction(const contact::Touch& touch, std::size_t i) { return i == 0 ? touch.normal : touch.tangent[i - 1]; }

// Adds the joint forces of a wrench on a body about a point (world axes), sign·Σ Eᵀ W along its path to the ground.
void add_joint_forces_of(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Force<double>& W,
                         const Vec3& point, double sign, double* force) {
  for (int b = body; b >= 0; b = tree.parent(b)) {
    const Kinematics<double>& k = workspace.bodies[at(b)];
    double own[6] = {};
    project(tree, b, joint_state(tree, q, workspace, b),
            {transpose_times(k.R, W.l), transpose_times(k.R, W.h + cross(point - k.r, W.l))}, own);
    for (int i = 0; i < info(tree.kind(b)).nv; ++i) force[tree.first_p(b) + i] += sign * own[i];
  }
}

// Derivative of a body's velocity, less gravity, at a point that moves: see touch().
Vec3 acceleration_at(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Vec3& point,
                     const Vec3& rate) {
  if (body < 0) return -tree.gravity();
  const Kinematics<double>& k = workspace.bodies[at(body)];
  const Motion<double> a = felt_acceleration(tree, q, workspace, body);
  const Vec3 w = k.R * k.velocity.w;
  return k.R * a.v + cross(k.R * a.w, point - k.r) + cross(w, rate);
}

// The rows of a group along which contacts hold: all three if they stick and `tangents` is true, the normal one otherwise.
void note_held_rows(ContactWorkspace& all, const ContactRows::Group& group, std::span<const Contact> contacts, bool tangents) {
  all.unknowns.clear();
  for (const std::size_t i : all.rows.of_group(group)) {
    all.unknowns.push_back(3 * i);
    if (tangents && contacts[i].mode == Contact::Mode::stick)
      all.unknowns.push_back(3 * i + 1), all.unknowns.push_back(3 * i + 2);
  }
}

// Solves A x = right for the rows that hold, group by group, and leaves zero elsewhere.
bool solve_rows(ContactWorkspace& all, std::span<const Contact> contacts, bool tangents, const std::vector<double>& right,
                std::vector<double>& x) {
  x.assign(right.size(), 0.0);
  for (const ContactRows::Group& group : all.rows.groups) {
    note_held_rows(all, group, contacts, tangents);
    const std::vector<std::size_t>& rows = all.unknowns;
    const std::size_t n = rows.size();
    all.matrix.resize(n * n), all.right.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) all.matrix[i * n + j] = all.rows.mobility(rows[i], rows[j]);
      all.right[i] = right[rows[i]];
    }
    if (!contact::solve_linear(all.matrix, all.right, all.columns, redundant)) return false;
    for (std::size_t i = 0; i < n; ++i) x[rows[i]] = all.right[i];
  }
  return true;
}

// Kinetic and potential energy less springs, at the last sweep.
double energy_of(const Tree& tree, const Workspace<double>& workspace) {
  double energy = 0;
  for (const int b : tree.order()) {
    const Kinematics<double>& body = workspace.bodies[at(b)];
    const RigidMass& mass = tree.link(b).body;
    energy += 0.5 * dot(body.velocity, momentum(mass, body.velocity)) - mass.m * dot(tree.gravity(), body.r) -
              dot(tree.gravity(), body.R * mass.mc);
  }
  for (int i = 0; i < tree.nv(); ++i) energy += 0.5 * tree.tables().armature[i] * workspace.v[at(i)] * workspace.v[at(i)];
  return energy;
}

}  // namespace

Force<double> contact_wrench(const Workspace<double>& workspace, int body, const Vec3& force, const Vec3& point) {
  const Kinematics<double>& k = workspace.bodies[at(body)];
  return {transpose_times(k.R, force), transpose_times(k.R, cross(point - k.r, force))};
}

void add_contact_row(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Vec3& along,
                     const Vec3& point, double sign, double* row) {
  add_joint_forces_of(tree, q, workspace, body, {along, {}}, point, sign, row);
}

void add_wrench_row(const Tree& tree, const double* q, const Workspace<double>& workspace, int body, const Force<double>& wrench,
                    double* row) {
  const Kinematics<double>& k = workspace.bodies[at(body)];
  add_joint_forces_of(tree, q, workspace, body, {k.R * wrench.l, k.R * wrench.h}, k.r, 1, row);
}

ContactWorkspace& contact_memory(Workspace<double>& workspace) {
  if (workspace.contacts == nullptr) workspace.contacts = {new ContactWorkspace, [](ContactWorkspace* all) { delete all; }};
  return *workspace.contacts;
}

std::vector<HeldForce>& held_forces(Workspace<double>& workspace) { return contact_memory(workspace).held; }

void add_held_stops(const Tree& tree, const Workspace<double>& workspace, double* tau) noexcept {
  if (workspace.contacts == nullptr) return;
  for (const HeldStop& stop : workspace.contacts->stops)
    if (const int b = tree.carrier(stop.joint); b >= 0 && tree.alive(b) && stop.dof < info(tree.kind(b)).nv)
      tau[tree.first_p(b) + stop.dof] += stop.force;
}

Vec3 belt_velocity(const Contact& contact, const contact::Touch& touch, const contact::Place& a, const contact::Place& b) {
  return cross(touch.normal, a.R * contact.belt_a + b.R * contact.belt_b);  // the outward normal of a is −n
}

void place_contacts(const Tree& tree, const Workspace<double>& workspace, std::span<const Contact> contacts, ContactRows& rows) {
  rows.touches.resize(contacts.size()), rows.velocity.resize(3 * contacts.size()), rows.belts.resize(3 * contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const contact::Place a = place_of(tree, workspace, c.a), b = place_of(tree, workspace, c.b);
    rows.touches[i] = contact::touch(c.features, a, b);
    const Vec3 v = contact::relative_velocity(rows.touches[i], a, b), belts = belt_velocity(c, rows.touches[i], a, b);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& along = direction(rows.touches[i], k);
      rows.belts[3 * i + k] = k == 0 ? 0 : dot(along, belts);
      rows.velocity[3 * i + k] = dot(along, v) + rows.belts[3 * i + k];
    }
  }
}

namespace {

constexpr double rounding_of_mobility = 1e-13;

// True if no DoF moves the two bodies along the row, apart from rounding: the joint forces of a unit force along it are compared
// with those of unit forces in all directions, and of the moments that coordinates of this size give them.
bool no_dof_moves(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                  const contact::Touch& touch, std::size_t k) {
  ContactWorkspace& all = contact_memory(workspace);
  const std::size_t nv = at(tree.nv());
  all.row.assign(nv, 0.0), all.row_size.assign(nv, 0.0);
  for (const auto& [body, sign] : {std::pair{contact.a, 1.0}, {contact.b, -1.0}}) {
    if (body < 0) continue;
    add_contact_row(tree, q, workspace, body, direction(touch, k), touch.point, sign, all.row.data());
    const auto sum = [](const Vec3& a) { return std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z); };
    const double length = norm(touch.point) + norm(workspace.bodies[at(body)].r);
    for (int b = body; b >= 0; b = tree.parent(b)) {
      const Kinematics<double>& kernel = workspace.bodies[at(b)];
      const Vec3 arm = transpose_times(kernel.R, touch.point - kernel.r);
      Motion<double> E[6];
      const int n = columns_of(tree, b, joint_state(tree, q, workspace, b), E);
      for (int i = 0; i < n; ++i)
        all.row_size[at(tree.first_p(b) + i)] += sum(E[i].v + cross(E[i].w, arm)) + length * sum(E[i].w);
    }
  }
  for (const int body : {contact.a, contact.b})
    for (int b = body; b >= 0; b = tree.parent(b))
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
        const std::size_t place = at(tree.first_p(b) + i);
        const bool moves = std::fabs(all.row[place]) > rounding_of_mobility * all.row_size[place];
        if (moves && (tree.link(b).locked >> i & 1u) == 0) return false;
      }
  return true;
}

// True if the loops let nothing move the two bodies along the row, apart from rounding. After no_dof_moves of the same row.
bool no_loop_lets_move(const Tree& tree, const double* q, Workspace<double>& workspace, double mobility) {
  if (!tree.has_loops()) return false;
  ContactWorkspace& all = contact_memory(workspace);
  all.unit_row = all.row;
  solve_with_factors<double>(tree, q, workspace, all.unit_row.data());
  double open = 0;  // the mobility if the loops were open
  for (std::size_t i = 0; i < all.row.size(); ++i) open += all.row[i] * all.unit_row[i];
  return mobility < rounding_of_mobility * open;
}

}  // namespace

RowOfRigid rigid_row(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                     const contact::Touch& touch, std::size_t k, double mobility, double velocity) {
  constexpr double rounding_of_speeds = 1e-9;
  double alone = 0, speeds = 0;
  for (int body : {contact.a, contact.b}) {
    if (body < 0) continue;
    const contact::Place place = place_of(tree, workspace, body);
    speeds += norm(place.v + cross(place.w, touch.point - place.r));
    while (body >= 0 && !(tree.link(body).body.m > 0)) body = tree.parent(body);  // which carries the massless one
    if (body < 0) continue;
    const RigidMass& mass = tree.link(body).body;
    const Kinematics<double>& kernel = workspace.bodies[at(body)];
    const Vec3 centre = (1 / mass.m) * mass.mc, arm = cross(touch.point - kernel.r - kernel.R * centre, direction(touch, k));
    const double about_origin = mass.J.xx + mass.J.yy + mass.J.zz;
    const double inertia = about_origin - 2 * mass.m * dot(centre, centre);  // above the largest principal one
    alone += 1 / mass.m + (inertia > 1e-14 * about_origin ? dot(arm, arm) / inertia : 0);
  }
  // The bodies alone are a rough scale: parts with hardly any inertia would move much more easily than they can.
  const bool rigid = mobility < rounding_of_mobility * alone &&
                     (no_dof_moves(tree, q, workspace, contact, touch, k) || no_loop_lets_move(tree, q, workspace, mobility));
  return {rigid, rigid && std::fabs(velocity) <= rounding_of_speeds * speeds};
}

void find_contact_accelerations(const Tree& tree, const double* q, const Workspace<double>& workspace,
                                std::span<const Contact> contacts, ContactRows& rows) {
  rows.acceleration.resize(3 * contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const contact::Touch& touch = rows.touches[i];
    const contact::Place a = place_of(tree, workspace, contacts[i].a), b = place_of(tree, workspace, contacts[i].b);
    const Vec3 rate = acceleration_at(tree, q, workspace, contacts[i].a, touch.point, touch.point_rate) -
                      acceleration_at(tree, q, workspace, contacts[i].b, touch.point, touch.point_rate);
    const Vec3 v = contact::relative_velocity(touch, a, b);
    rows.acceleration[3 * i] = dot(touch.normal, rate) + dot(touch.normal_rate, v);
    // The tangents turn with the normal only: n × ṅ. Across a contact that sticks the velocity is zero.
    const Vec3 spin = cross(touch.normal, touch.normal_rate);
    const Vec3 belt_a = a.R * contacts[i].belt_a, belt_b = b.R * contacts[i].belt_b;
    const Vec3 of_belts =
        cross(touch.normal_rate, belt_a + belt_b) + cross(touch.normal, cross(a.w, belt_a) + cross(b.w, belt_b));
    for (std::size_t k = 0; k < 2; ++k)
      rows.acceleration[3 * i + k + 1] = dot(touch.tangent[k], rate + of_belts) + dot(cross(spin, touch.tangent[k]), v);
  }
}

Vec3 spin_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, const Contact& contact) {
  const auto of = [&](int body) {
    return body < 0 ? Vec3{} : workspace.bodies[at(body)].R * felt_acceleration(tree, q, workspace, body).w;
  };
  return of(contact.a) - of(contact.b);
}

namespace {

// Where the least forces pull, or leave their cones, others with the same effect may not.
void share_forces(std::span<const Contact> contacts, ContactRows::Group& group, ContactWorkspace& all, bool at_state) {
  constexpr double rounding = 1e-12;
  group.shared = false, group.redundant = !all.independent.empty();
  if (!group.redundant) return;
  all.cones.clear();
  for (std::size_t i = 0; i < all.unknowns.size(); ++i) {
    const Contact& c = contacts[all.unknowns[i] / 3];
    if (all.unknowns[i] % 3 == 0) all.cones.push_back({i, c.mode == Contact::Mode::stick ? c.friction : 0});
  }
  double size = 0, margin = 0;
  for (const double x : all.right) size = std::max(size, std::fabs(x));
  for (const contact::ForceCone& cone : all.cones) margin = std::min(margin, cone.margin(all.right));
  if (margin >= -rounding * size) return;
  group.shared = true;
  all.shared.choose(all.right, all.independent, all.cones);
  if (at_state) group.margin = all.shared.margin();
}

// Forces without effect: what the equations, which are orthonormal, leave of forces that have nothing to do with them. A contact
// that has no part in these is determined.
void note_open(ContactWorkspace& all) {
  constexpr double rounding = 1e-7;
  const std::size_t n = all.unknowns.size();
  if (all.independent.empty()) return;
  std::vector<double>& free = all.change;
  free.resize(n);
  for (std::size_t i = 0; i < n; ++i) free[i] = sine_cosine(1.0 + static_cast<double>(i)).s;
  for (std::size_t k = 0; k < all.independent.size(); k += n) {
    double along = 0;
    for (std::size_t i = 0; i < n; ++i) along += all.independent[k + i] * free[i];
    for (std::size_t i = 0; i < n; ++i) free[i] -= along * all.independent[k + i];
  }
  for (std::size_t i = 0; i < n; ++i) all.rows.open[all.unknowns[i]] = std::fabs(free[i]) > rounding ? free[i] : 0;
}

// Redundant equations may contradict each other: no forces keep contacts that a prescribed motion pulls apart. What the forces
// leave of the accelerations then counts as what they lack.
void note_contradiction(ContactRows::Group& group, const ContactWorkspace& all) {
  constexpr double contradicts =
      1e-7;  // of the largest acceleration; velocities that impacts leave contradict each other by less
  const ContactRows& rows = all.rows;
  double most = 0, size = 0;
  for (const std::size_t row : all.unknowns) {
    double left = rows.acceleration[row];
    for (const std::size_t j : rows.of_group(group))
      for (std::size_t k = 0; k < 3; ++k) left += rows.mobility(row, 3 * j + k) * rows.forces[3 * j + k];
    most = std::max(most, std::fabs(left)), size = std::max(size, std::fabs(rows.acceleration[row]));
  }
  if (most > contradicts * size) group.shared = true, group.margin = -most / size;
}

// Unknowns: all three forces of contacts that stick, the normal force of the others.
void find_forces_of_group(std::span<const Contact> contacts, ContactRows::Group& group, ContactWorkspace& all, bool at_state) {
  ContactRows& rows = all.rows;
  note_held_rows(all, group, contacts, true);
  const std::vector<std::size_t>& of = all.unknowns;
  const std::size_t n = of.size();
  all.matrix.resize(n * n), all.right.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t c = of[j] / 3;
      double element = rows.mobility(of[i], of[j]);
      if (contacts[c].mode == Contact::Mode::slip)
        for (std::size_t k = 0; k < 2; ++k)
          element -= contacts[c].friction * dot(rows.slip[c], rows.touches[c].tangent[k]) * rows.mobility(of[i], 3 * c + k + 1);
      all.matrix[i * n + j] = element;
    }
    all.right[i] = -rows.acceleration[of[i]];
  }
  if (!contact::solve_linear(all.matrix, all.right, all.columns, redundant, &all.independent))
    std::fill(all.right.begin(), all.right.end(), NAN);  // the step then says that the motion diverged
  else
    share_forces(contacts, group, all, at_state);
  for (std::size_t j = 0; j < n; ++j) rows.forces[of[j]] = all.right[j];
  if (at_state) note_open(all);
  for (const std::size_t i : rows.of_group(group)) {
    if (contacts[i].mode != Contact::Mode::slip) continue;
    for (std::size_t k = 0; k < 2; ++k)
      for (std::vector<double>* all_of : {&rows.forces, &rows.open})
        (*all_of)[3 * i + k + 1] = -contacts[i].friction * (*all_of)[3 * i] * dot(rows.slip[i], rows.touches[i].tangent[k]);
  }
  if (at_state && !all.independent.empty()) note_contradiction(group, all);
}

}  // namespace

void find_contact_forces(const Tree& tree, const double* q, Workspace<double>& workspace, bool at_state) {
  ContactWorkspace& all = contact_memory(workspace);
  ContactRows& rows = all.rows;
  const std::span<const Contact> contacts = tree.contacts();
  place_contacts(tree, workspace, contacts, rows);
  find_contact_accelerations(tree, q, workspace, contacts, rows);
  find_contact_mobility(tree, q, workspace, contacts, rows);
  const bool known = all.topology == tree.revision();
  if (at_state || !known) {
    all.topology = tree.revision();
    all.chosen_slip.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) all.chosen_slip[i] = contacts[i].direction;
  }
  rows.slip.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].mode != Contact::Mode::slip) continue;
    const contact::Touch& touch = rows.touches[i];
    const Vec3 v = rows.velocity[3 * i + 1] * touch.tangent[0] + rows.velocity[3 * i + 2] * touch.tangent[1];
    const double speed = norm(v);
    const bool moves = speed > slowest_slip && (at_state || dot(v, all.chosen_slip[i]) > 0);
    const double keeps = contacts[i].keeps_direction;
    Vec3 s = keeps > 0 ? v + keeps * contacts[i].direction : moves ? (1 / speed) * v : all.chosen_slip[i];
    s -= dot(s, touch.normal) * touch.normal;
    rows.slip[i] = norm(s) > 0 ? normalized(s) : touch.tangent[0];
    if (at_state) all.chosen_slip[i] = rows.slip[i];
  }
  rows.forces.assign(3 * contacts.size(), 0.0), rows.open.assign(3 * contacts.size(), 0.0);
  for (ContactRows::Group& group : rows.groups) find_forces_of_group(contacts, group, all, at_state);
}

void add_contact_loads(const Tree& tree, Workspace<double>& workspace) noexcept {
  const ContactRows& rows = workspace.contacts->rows;
  const std::span<const Contact> contacts = tree.contacts();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const contact::Touch& touch = rows.touches[i];
    Vec3 force{};
    for (std::size_t k = 0; k < 3; ++k) force += rows.forces[3 * i + k] * direction(touch, k);
    if (contacts[i].a >= 0) workspace.loads[at(contacts[i].a)] += contact_wrench(workspace, contacts[i].a, force, touch.point);
    if (contacts[i].b >= 0) workspace.loads[at(contacts[i].b)] += contact_wrench(workspace, contacts[i].b, -force, touch.point);
    for (std::size_t k = 1; k < 3; ++k) {
      if (contacts[i].mode == Contact::Mode::slip)
        workspace.power.dissipated -= rows.forces[3 * i + k] * rows.velocity[3 * i + k];
      workspace.power.work -= rows.forces[3 * i + k] * rows.belts[3 * i + k];
    }
  }
}

namespace {

// Evaluates without the contacts and places them.
void place_at(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
              std::span<const Contact> contacts, ContactRows& rows) {
  evaluate_velocities_without_contacts(tree, t, q, u, workspace, LoopRows::kept);
  locate_stage(tree, q, workspace);
  place_contacts(tree, workspace, contacts, rows);
}

// Y x for numbers by row.
void moved_by(const Tree& tree, const ContactRows& rows, const std::vector<double>& x, std::vector<double>& move) {
  move.assign(at(tree.nv()), 0.0);
  for (std::size_t row = 0; row < x.size(); ++row) rows.add_row(rows.Y, row, x[row], move.data());
}

// Sets the gaps to zero by small motions.
bool close_gaps(const Tree& tree, double t, double* q, const double* u, Workspace<double>& workspace) {
  ContactWorkspace& all = *workspace.contacts;
  ContactRows& rows = all.rows;
  const std::size_t contacts = tree.contacts().size();
  for (int k = 0; k < 4; ++k) {
    all.missing.assign(3 * contacts, 0.0);
    double most = 0, size = 1;
    for (std::size_t i = 0; i < contacts; ++i) {
      all.missing[3 * i] = -rows.touches[i].gap;
      most = std::max(most, std::fabs(rows.touches[i].gap)), size = std::max(size, norm(rows.touches[i].point));
    }
    if (!std::isfinite(most)) return false;
    if (most < 1e-15 * size) break;
    find_contact_mobility(tree, q, workspace, tree.contacts(), rows);
    if (!solve_rows(all, tree.contacts(), false, all.missing, all.change)) return false;
    moved_by(tree, rows, all.change, all.move);
    detail::displace(tree, all.move.data(), 1, q);
    place_at(tree, t, q, u, workspace, tree.contacts(), rows);
  }
  return true;
}

// Of contacts that are placed: the impulses along their rows, in all.change.
bool find_stopping_impulses(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts) {
  ContactWorkspace& all = *workspace.contacts;
  ContactRows& rows = all.rows;
  all.missing.resize(3 * contacts.size());
  find_contact_mobility(tree, q, workspace, contacts, rows);
  for (std::size_t row = 0; row < all.missing.size(); ++row) all.missing[row] = -rows.velocity[row];
  return solve_rows(all, contacts, true, all.missing, all.change);
}

}  // namespace

bool close_contacts(const Tree& tree, double t, double* q, double* u, Workspace<double>& workspace, double& energy) {
  ContactWorkspace& all = contact_memory(workspace);
  place_at(tree, t, q, u, workspace, tree.contacts(), all.rows);
  energy -= energy_of(tree, workspace);
  if (!close_gaps(tree, t, q, u, workspace)) return false;
  if (tree.has_loops()) {  // the rows of its loops have turned with it
    close_loop_velocities(tree, t, q, u, workspace, {});
    place_at(tree, t, q, u, workspace, tree.contacts(), all.rows);
  }
  if (!find_stopping_impulses(tree, q, workspace, tree.contacts())) return false;
  moved_by(tree, all.rows, all.change, all.move);
  for (std::size_t k = 0; k < all.move.size(); ++k) u[k] += all.move[k];
  place_at(tree, t, q, u, workspace, tree.contacts(), all.rows);
  energy += energy_of(tree, workspace);
  return true;
}

bool find_stopping_impulses(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                            std::span<const Contact> contacts) {
  place_at(tree, t, q, u, workspace, contacts, contact_memory(workspace).rows);
  return find_stopping_impulses(tree, q, workspace, contacts);
}

}  // namespace momentree
